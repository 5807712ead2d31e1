"""The version of Leadscrew."""

__version__ = "0.1.0"
