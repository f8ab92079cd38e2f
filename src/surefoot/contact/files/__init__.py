"""Contact problems in files: FCLIB, Siconos text and .npz."""
