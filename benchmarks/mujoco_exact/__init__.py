"""MuJoCo's step beside the exact one: price, accuracy, other people's models, pictures."""
