"""Sensors: blocks that turn what a plant shows into what a controller sees, one file each."""
