"""Tangential cutting without a sensor: drawings to G-code, and from a measured piece the program of the next."""
