"""Named problem sets and measurements against rivals in the same run."""
