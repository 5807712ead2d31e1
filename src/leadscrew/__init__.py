"""Leadscrew: intelligent control of machine-tool axes and cutting processes."""

__version__ = "0.1.0"
