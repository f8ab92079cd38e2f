"""Motion references: reading what people retarget, and whether the ground could give the forces that they need."""
