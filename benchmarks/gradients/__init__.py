"""Gradients through contact: penalty, implicit, randomised smoothing; docs/reports/gradients.md."""
