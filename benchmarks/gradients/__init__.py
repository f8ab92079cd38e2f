"""Gradients through contact by three methods: penalty, implicit, randomised smoothing; docs/gradients.md."""
