"""Plots, pictures and reports; matplotlib is imported in the functions that draw."""
