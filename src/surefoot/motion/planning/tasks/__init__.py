"""What can be planned: one file per task, one line in the table."""
