"""Fuzzy force control of the study ``grey_turning`` with and without grey prediction, and what it is held against."""

from leadscrew.controllers._grey_fuzzy.gpfc import gpfc
from leadscrew.controllers._grey_fuzzy.pi_incremental import pi_incremental
from leadscrew.controllers._grey_fuzzy.smith import smith
from leadscrew.controllers._grey_fuzzy.tfc import tfc

__all__ = ["gpfc", "pi_incremental", "smith", "tfc"]
