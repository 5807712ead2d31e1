"""How much of the widest sweeps is run: CI runs a part; ``LEADSCREW_SWEEPS=whole`` runs all, before a release."""

import os
from collections.abc import Sequence
from typing import TypeVar

T = TypeVar("T")
WHOLE = os.environ.get("LEADSCREW_SWEEPS") == "whole"


def some(cases: Sequence[T], every: int) -> Sequence[T]:
    """Each ``every``-th of the cases, or all."""
    return cases if WHOLE else cases[::every]
