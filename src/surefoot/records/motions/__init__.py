"""Motion references: configurations over time that people retarget and would have a robot track."""
