"""Actuators: blocks between a controller's output and a plant's input, one file each."""
