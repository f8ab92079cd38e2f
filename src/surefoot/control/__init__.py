"""Controllers: force distribution, standing, walking."""
