"""What other tools read: one file per target, one line in the table."""
