"""Sliding-mode controllers of a stage with friction, after Shams and Safdari (2010)."""
