"""Disturbances: blocks that load a plant, one file each. The load is in the unit that the plant says."""
