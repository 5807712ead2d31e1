"""The sizes of the fit as faults, with the units in which each is usually given."""

from __future__ import annotations

import math
from collections.abc import Sequence, Set
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.analysis.circular import signatures
from leadscrew.analysis.circular.paths import CircularTest, Floats
from leadscrew.analysis.circular.shapes import Member

if TYPE_CHECKING:
    from leadscrew.analysis.circular.search import Data


@dataclass(frozen=True)
class Fault:
    """One fault and its size."""

    name: str
    axis: str
    """Axis, or both for what belongs to the pair."""
    um: float | None
    """Size as its signature defines it; None where the data cannot tell it from another fault."""
    uncertainty_um: float | None
    """Standard uncertainty of the fit alone."""
    drawn_um: float
    """Peak to peak of what it draws on this circle."""
    more: dict[str, float] = field(default_factory=dict)
    """Further values by name and unit: ``ppm``, ``urad``, ``ms``, ``lead_mm``, ``rise_deg``..."""


def faults_of(
    test: CircularTest, data: Data, members: Sequence[Member], design: Floats, sizes: Floats, uncertain: Floats,
    hidden: Set[int],
) -> list[Fault]:  # fmt: skip
    """One fault for each signature; of cyclic error the amplitude."""
    found = []
    for i, name in enumerate(signatures.BASE):
        shown = _named(name, test.axes)
        if i in hidden:
            found.append(Fault(shown, _axis(name, test.axes), None, None, 0.0))
            continue
        size = float(sizes[i])
        drawn = float(np.ptp(design[:, i] * size))
        found.append(Fault(shown, _axis(name, test.axes), size, float(uncertain[i]), drawn, _usual(name, size, test)))
    at = len(signatures.BASE)
    seen = {(m.kind.name, m.which): m for m in members}
    for kind in ("cyclic error", "stick motion", "stick-slip"):
        for which in (0, 1):
            if (kind, which) not in seen:
                axis = test.axes[which]
                found.append(Fault(f"{kind} {axis}", axis, 0.0, None, 0.0))
    for member in members:
        width = member.columns(data).shape[1]
        part, sure = sizes[at : at + width], uncertain[at : at + width]
        size = float(np.linalg.norm(part)) if width == 2 else float(part[0])
        unsure = float(np.linalg.norm(part * sure) / size) if width == 2 and size else float(sure[0])
        axis = test.axes[member.which]
        drawn = float(np.ptp(design[:, at : at + width] @ part))
        more = dict(zip(member.kind.parts, member.shape, strict=True))
        if "per_radius" in more:
            more = {"lead_mm": test.radius_mm / more["per_radius"], "phase_rad": math.atan2(part[1], part[0])}
        found.append(Fault(f"{member.kind.name} {axis}", axis, size, unsure, drawn, more))
        at += width
    return found


def _named(name: str, axes: tuple[str, str]) -> str:
    """The name with the axes of the test in place of X and Y."""
    what, _, axis = name.rpartition(" ")
    if axis[:1] in signatures.AXES and what:
        return f"{what} {axes[signatures.AXES.index(axis[0])]}{axis[1:]}"
    return name


def _axis(name: str, axes: tuple[str, str]) -> str:
    last = name.rsplit(" ", 1)[-1][:1]
    return axes[signatures.AXES.index(last)] if last in signatures.AXES else "both"


def _usual(name: str, size: float, test: CircularTest) -> dict[str, float]:
    """The same in the unit in which the fault is usually given."""
    if name.startswith("scale"):
        return {"ppm": 1000.0 * size / test.radius_mm}
    if name == "squareness":
        return {"urad": 1000.0 * size / test.radius_mm}
    if name == "servo mismatch" and test.feed_mm_min is not None:
        return {"ms": 60.0 * size / test.feed_mm_min}
    return {}
