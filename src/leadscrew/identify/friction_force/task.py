"""One fit: a record, its load, and which samples may be looked at."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from leadscrew.friction.static_map import Sliding
from leadscrew.identify.axis.result import How, Parameter
from leadscrew.identify.friction_force.record import ForceRecord
from leadscrew.identify.friction_force.result import Load, ModelFit
from leadscrew.identify.friction_force.search import Found, whiteness

USEFUL = 0.5
"""Half of an interval over the value, beyond which the log is said not to tell the parameter."""
VISCOUS_RATIO = 2.0
"""Fast over slow sliding below which a viscous part cannot be told from Coulomb friction."""
STRIBECK_RATIO = 3.0
"""The same for a Stribeck fall."""


class Task(NamedTuple):
    """What is fitted to what."""

    record: ForceRecord
    load: Load
    weight: np.ndarray
    """Normal force, N; 1 for a model in newtons."""
    last: int
    """Samples that may be looked at."""
    speeds: tuple[float, float]
    """Slow and fast sliding in them."""

    @property
    def ratio(self) -> float:
        """Fast over slow sliding."""
        slow, fast = self.speeds
        return fast / slow if slow > 0.0 else np.inf

    def units(self) -> dict[str, str]:
        """Unit of each kind of parameter."""
        force, way = (
            ("", self.record.unit) if self.load == "coefficient" else (self.record.force_unit, self.record.unit)
        )
        per = f"{force} " if force else ""
        return {
            "force": force or "1", "stiffness": f"{force or '1'}/{way}", "damping": f"{per}s/{way}",
            "speed": f"{way}/s", "exponent": "1", "travel": way,
        }  # fmt: skip


def task_of(record: ForceRecord, load: Load, last: int) -> Task:
    """The task of the first ``last`` samples."""
    weight = record.normal if load == "coefficient" and record.normal is not None else np.ones(len(record.time))
    return Task(record, load, weight, last, sliding_speeds(record, last))


def sliding_speeds(record: ForceRecord, last: int) -> tuple[float, float]:
    """Speeds that 5 % and 95 % of the travel are slower than."""
    way, speed = np.abs(record.travel[:last]), np.abs(record.speed[:last])
    order = np.argsort(speed)
    share = np.cumsum(way[order])
    low, high = np.searchsorted(share, [0.05 * share[-1], 0.95 * share[-1]])
    return float(speed[order][low]), float(speed[order][high])


def without_rise(way: Sliding, side: str, why: str) -> dict[str, tuple[float, str, str]]:
    """Static friction and Stribeck speed of a direction, fixed because none was found."""
    return {
        f"friction.{side}.static": (way.static, "force", f"as Coulomb: {why}"),
        f"friction.{side}.stribeck_speed": (way.stribeck_speed, "speed", "without effect: static is Coulomb"),
    }


def parameters(
    keys: Mapping[str, tuple[str, np.ndarray]], found: Found, task: Task, fixed: Mapping[str, tuple[float, str, str]]
) -> dict[str, Parameter]:
    """Parameters with intervals: each key is a sum of fitted values (unit kind, weights); ``fixed`` have a reason."""
    units, out = task.units(), {}
    for key, (kind, weights) in keys.items():
        used = weights != 0.0
        value = float(weights @ found.values)
        variance = float(weights[used] @ found.covariance[np.ix_(used, used)] @ weights[used])
        if not np.isfinite(variance):
            out[key] = Parameter(value, units[kind], np.nan, np.nan, "fitted", False, "on its bound, or without effect")
            continue
        reach = found.quantile * float(np.sqrt(variance))
        told = reach <= USEFUL * abs(value)
        note = "" if told else "its interval is too wide to be of use"
        out[key] = Parameter(value, units[kind], value - reach, value + reach, "fitted", told, note)
    for key, (value, kind, why) in fixed.items():
        how: How = "fixed"
        out[key] = Parameter(value, units[kind], np.nan, np.nan, how, False, why)
    return out


def judged(
    task: Task, name: str, friction: Any, simulated: np.ndarray, given: dict[str, Parameter], *, amplitude: float,
    offset: float = 0.0, condition: float = float("nan"), notes: tuple[str, ...] = (),
) -> ModelFit:  # fmt: skip
    """A model with its errors: ``simulated`` is its force over the whole record, N."""
    left = task.record.force - simulated
    seen, rest = left[: task.last], left[task.last :]
    rms = float(np.sqrt(np.mean(seen**2)))
    held = float(np.sqrt(np.mean(rest**2))) if len(rest) else float("nan")
    worst = float(np.abs(rest).max()) if len(rest) else float("nan")
    percent = 100.0 / amplitude
    return ModelFit(
        name, task.load, friction, given, offset, simulated, rms, held, worst, percent * rms, percent * held, condition,
        whiteness(seen), notes,
    )  # fmt: skip
