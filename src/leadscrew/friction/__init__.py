"""Friction models: plain functions and their parameters, for plants and for controllers that know the friction."""
