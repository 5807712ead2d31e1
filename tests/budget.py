"""How much of the widest sweeps is run: CI runs a part; ``LEADSCREW_SWEEPS=whole`` runs all, before a release."""

import os
from collections.abc import Collection, Iterable, Sequence
from typing import Any, TypeVar

import pytest

T = TypeVar("T")
WHOLE = os.environ.get("LEADSCREW_SWEEPS") == "whole"


def some(cases: Sequence[T], every: int) -> Sequence[T]:
    """Each ``every``-th of the cases, or all."""
    return cases if WHOLE else cases[::every]


def in_every_run(cases: Iterable[Any], quick: Collection[Any]) -> list[Any]:
    """The cases of a parametrised test, of which `make test` runs the ``quick`` ones and CI all."""
    return [case if case in quick else pytest.param(case, marks=pytest.mark.slow) for case in cases]
