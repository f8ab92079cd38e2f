"""Contact laws as values; the rigid ones and, in `soft/`, the compliant ones."""
