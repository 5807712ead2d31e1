"""Runs of the study grey_turning that several test files look at, made once in a process."""

from functools import cache

from leadscrew.studies.grey_turning.reproduction import Reproduction
from leadscrew.studies.grey_turning.runs import Loops


@cache
def reproduction() -> Reproduction:
    """The paper's experiments, on loops of their own."""
    return Reproduction(Loops())
