"""Questions to a stance: can it stand, how much friction does it need, where may its centre of mass be."""
