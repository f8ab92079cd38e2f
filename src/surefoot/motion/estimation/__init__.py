"""State estimation: contact detection, the invariant filter, forces on feet, unknown loads."""
