"""What walking loses without each of its behaviours and heuristics, and how its settings were chosen."""
