"""Motion references: what people retarget and robots execute, read as configurations over time."""
