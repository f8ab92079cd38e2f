"""What robots do that nobody tuned: how their feet are read, what the lint says, and whether they walk."""
