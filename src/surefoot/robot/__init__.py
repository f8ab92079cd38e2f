"""A robot on Pinocchio: model, feet, Jacobians, dynamics."""
