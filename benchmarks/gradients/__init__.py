"""Gradients through contact on three roads: penalty, implicit, randomised smoothing; docs/gradients.md."""
