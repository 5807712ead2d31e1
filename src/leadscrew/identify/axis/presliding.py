"""Pre-sliding (LuGre) of an axis from its log, where the log excites it: :mod:`leadscrew.identify.friction` in m and N.

The fit of friction is made for rad and N m. Here its "radian" is 1 mm of a linear axis: with ``L`` = 1 mm

    torque = L force      angle = x / L      sigma_0 = stiffness / L^2      F_C = torque / L      v_s = L speed

For a rotary axis ``L`` is 1. What it needs of a log says :mod:`leadscrew.identify.friction_record`: slow reversals, or
a drive that creeps up to a slip, sampled every 2 ms or faster.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from leadscrew.kernel.errors import DataError

if TYPE_CHECKING:
    from leadscrew.logs import AxisLog

TURN = 1e-3
"""m of a linear axis that count as a radian."""
NORMAL = 1.96
"""Standard errors to each side of a 95 % interval."""


class Presliding(NamedTuple):
    """LuGre by key of the plant, or why the log does not tell it."""

    values: dict[str, float]
    """``mass``, ``offset``, ``friction.stiffness``, ``friction.damping``, ``friction.forward.*``: alike both ways."""
    interval: dict[str, tuple[float, float]]
    """95 %; infinite where the log does not tell it. Standard errors are lower bounds, as the friction fit says."""
    told: dict[str, bool]
    consistent: bool
    """Whether the residuals are white and no larger than the noise: if not, this is no LuGre axis."""
    rms: float
    """Of position around stand-stills, m or rad."""
    why_not: str = ""
    """A sentence; empty where stiffness and damping are told."""

    @property
    def found(self) -> bool:
        """Whether there is a model of pre-sliding."""
        return not self.why_not


def presliding(
    log: AxisLog,
    values: Mapping[str, float],
    delay_s: float = 0.0,
    progress: Callable[[str, float], None] | None = None,
) -> Presliding:
    """LuGre friction of the axis, alike both ways, from the stand-stills of its log.

    Args:
        log: is not changed.
        values: the model so far; of it ``force_per_drive`` and ``mass`` count.
        delay_s: from a logged drive to its act; whole periods of it are taken.
        progress: is told what happens and the fraction done.
    """
    from leadscrew.identify.friction import fit_friction

    turn = TURN if log.unit.position == "m" else 1.0
    force = log.drive * values.get("force_per_drive", log.force_per_drive or 1.0)
    mass = values.get("mass")
    try:
        fit = fit_friction(
            log.time, force * turn, log.position / turn, inertia=None if mass is None else mass * turn * turn,
            delay=round(delay_s / log.period), progress=progress,
        )  # fmt: skip
    except DataError as error:
        text = str(error)
        return Presliding({}, {}, {}, False, math.nan, f"Pre-sliding is not told: {text}.")
    scale = {"stiffness": turn**-2, "damping": turn**-2, "viscous": turn**-2, "inertia": turn**-2,
             "coulomb": 1 / turn, "static": 1 / turn, "offset": 1 / turn, "stribeck_speed": turn}  # fmt: skip
    found = fit.friction._asdict() | {"inertia": fit.inertia, "offset": fit.offset}
    known = fit.identifiable | {"inertia": True, "offset": True}
    named = {_key(n): found[n] * scale[n] for n in found}
    reach = {_key(n): NORMAL * fit.standard_error[n] * scale[n] for n in found}
    return Presliding(
        values=named, interval={k: (v - reach[k], v + reach[k]) for k, v in named.items()},
        told={_key(n): known[n] for n in found}, consistent=fit.consistent, rms=fit.rms * turn,
    )  # fmt: skip


def _key(name: str) -> str:
    if name in ("stiffness", "damping"):
        return f"friction.{name}"
    return {"inertia": "mass", "offset": "offset"}.get(name, f"friction.forward.{name}")
