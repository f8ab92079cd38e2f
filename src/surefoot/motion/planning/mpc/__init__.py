"""Contact-implicit model predictive control: a robot walks without a gait."""
