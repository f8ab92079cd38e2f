"""Contacts, limits, joints and dry friction together, as rows of a Jacobian: exact laws in the velocities.

A contact problem in forces (`contact.problem`) has as many unknowns as rows; here the unknowns are the
velocities of the mechanism, of which it has few, however many rows hold it.
"""
