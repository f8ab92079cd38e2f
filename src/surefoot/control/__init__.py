"""Controllers: standing, walking, on four feet and two."""
