"""Step 3 of a design: how strongly the old controller's law bends along e and ec, where the log can tell.

Polynomials of degree 2 and 3 in (e, ec) are fitted to the duty (:mod:`leadscrew.fuzzy.curvature`). A step response is a
curve in the plane of e and ec, not a region, and along a curve the two curvatures cannot be told apart: the condition
number of the fit says so, and a fit above the limit is refused. Of the degrees that pass the highest is taken. The
numbers may be given instead; the paper read 1.96 and 1.35 off a scope, (8) and (9).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from leadscrew.fuzzy.curvature import estimate_curvature
from leadscrew.kernel.errors import ValueRefused

DEGREES = (2, 3)
MOST_CONDITION = 30.0
"""Random samples of two inputs give 1 to 20 (:mod:`leadscrew.fuzzy.curvature`)."""


@dataclass(frozen=True)
class Attempt:
    """One fit."""

    degree: int
    condition: float
    """Infinite where the fit has no unique answer, or too few samples."""
    values: tuple[float, ...]
    error: tuple[float, ...]
    """Standard errors of ``values``."""
    said: str
    """Why it is refused; empty where it is not."""


@dataclass(frozen=True)
class Bending:
    """Curvatures u_ee and u_cc on universes scaled to [-1, 1], or why there are none."""

    values: tuple[float, float] | None
    source: Literal["given", "estimated", "refused"]
    attempts: tuple[Attempt, ...]
    most_condition: float = MOST_CONDITION

    def lines(self) -> list[str]:
        """The step as text."""
        lines = [
            f"degree {a.degree}: {a.said}" if a.said else
            f"degree {a.degree}: u_ee {a.values[0]:.3g} +- {a.error[0]:.2g}, u_cc {a.values[1]:.3g} +- "
            f"{a.error[1]:.2g}, condition number {a.condition:.3g}"
            for a in self.attempts
        ]  # fmt: skip
        if self.values is None:
            return [*lines, "no curvature: log moves of several sizes with an added excitation, or give --curvature"]
        return [*lines, f"{self.source}: u_ee {self.values[0]:.4g}, u_cc {self.values[1]:.4g}"]

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        return asdict(self)


def find_bending(
    samples: np.ndarray, given: Sequence[float] | None = None, most_condition: float = MOST_CONDITION
) -> Bending:
    """The step for samples ``(e, ec, duty)`` on [-1, 1]; ``given`` curvatures are taken, and the fits still shown.

    Raises:
        ValueRefused: other than two given curvatures, or negative ones.
    """
    if given is not None and (len(given) != 2 or not all(0.0 <= c < math.inf for c in given)):
        raise ValueRefused(f"curvature = {', '.join(f'{c:g}' for c in given)}: expected u_ee and u_cc, 0 or more")
    attempts = tuple(_attempt(samples, degree, most_condition) for degree in DEGREES)
    if given is not None:
        return Bending((float(given[0]), float(given[1])), "given", attempts, most_condition)
    passed = [a for a in attempts if not a.said]
    if not passed:
        return Bending(None, "refused", attempts, most_condition)
    return Bending((passed[-1].values[0], passed[-1].values[1]), "estimated", attempts, most_condition)


def _attempt(samples: np.ndarray, degree: int, most_condition: float) -> Attempt:
    try:
        found = estimate_curvature(
            samples[:, :2], samples[:, 2], ((-1.0, 1.0),) * 2, method="polynomial", degree=degree,
            most_condition=math.inf,
        )  # fmt: skip
    except ValueRefused as problem:
        return Attempt(degree, math.inf, (), (), f"refused: {problem}")
    refused = (
        f"refused: condition number {found.condition:.3g}, allowed is {most_condition:g}: the samples do not tell u_ee "
        "from u_cc"
    )
    said = refused if found.condition > most_condition else ""
    return Attempt(degree, found.condition, found.values, found.error, said)
