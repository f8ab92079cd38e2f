"""Robots that speak DDS: Unitree's low-level messages, their checksums, and a loop at the end of the wire."""
