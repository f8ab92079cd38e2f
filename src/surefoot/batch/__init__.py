"""Many contact problems at once: on threads, and in JAX, PyTorch and Warp."""
