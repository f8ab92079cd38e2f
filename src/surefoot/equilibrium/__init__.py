"""Questions to a stance: can it stand, what friction does it need, where may its weight be, who bears it."""
