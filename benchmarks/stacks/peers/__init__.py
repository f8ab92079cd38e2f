"""Programs that run in the peers' own processes: an adapter each, on top of the user's checkout."""
