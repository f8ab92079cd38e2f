"""What a controller is, and the controllers of forces: model-predictive control and whole-body control."""
