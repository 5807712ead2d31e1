"""A measured friction force and the motion that made it, ready to be fitted.

Signs as everywhere in Leadscrew: a positive force resists a positive speed. Friction takes energy out of the motion,
``sum F dx > 0``; a log whose sum is negative has the other sign, and is turned and said to be.

A position that flickers by a count of its encoder would bend bristles that do not move. So up to two counts against
the last direction are no reversal; three are. The speed is the slope over a few samples, so many that one count is 2 %
of the usual speed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from leadscrew.identify.friction_force.checks import check_motion, check_time
from leadscrew.kernel.errors import DataError, ValueRefused
from leadscrew.logs.finding import Finding
from leadscrew.logs.jumps import jumps

LEAST = 50
"""Samples below which nothing is fitted."""
COUNT_IN_SPEED = 0.02
"""Share of the usual speed that one count may be."""
NO_WORK = 0.05
"""Share of ``sum |F dx|`` below which ``sum F dx`` is no work."""


@dataclass(frozen=True)
class ForceRecord:
    """Samples of a friction force."""

    time: np.ndarray
    """s, rising; steps may differ."""
    position: np.ndarray
    """m or rad, from 0 at the first sample; the integral of the speed where only that was logged."""
    travel: np.ndarray
    """m or rad, from the sample before, without flicker of two counts; 0 for the first."""
    speed: np.ndarray
    """m/s or rad/s."""
    force: np.ndarray
    """N or N m; positive against a positive speed."""
    normal: np.ndarray | None
    """N, where it was logged."""
    unit: Literal["m", "rad"]
    source: str
    turned: bool
    """The log had the other sign."""
    encoder_step: float
    """Smallest step of the position; 0 where there is none to be seen."""
    findings: list[Finding] = field(default_factory=list)

    @property
    def force_unit(self) -> str:
        """Of the force."""
        return "N" if self.unit == "m" else "N m"

    @cached_property
    def way(self) -> np.ndarray:
        """Sign of the motion, or of the last one while it rests; 0 before the first."""
        sign = np.sign(self.travel)
        last = np.maximum.accumulate(np.where(sign != 0.0, np.arange(len(sign)), -1))
        return np.where(last >= 0, sign[np.maximum(last, 0)], 0.0)

    @cached_property
    def strokes(self) -> np.ndarray:
        """Number of the stroke of each sample: one more at every reversal."""
        way = self.way
        turned = (way[1:] != way[:-1]) & (way[:-1] != 0.0)
        return np.concatenate([[0], np.cumsum(turned)])

    @cached_property
    def since_reversal(self) -> np.ndarray:
        """Travel since the last reversal, m or rad."""
        total, strokes = np.cumsum(np.abs(self.travel)), self.strokes
        first = np.searchsorted(strokes, np.arange(strokes[-1] + 1))
        before = np.where(first > 0, total[np.maximum(first - 1, 0)], 0.0)
        return total - before[strokes]


def force_record(
    time: np.ndarray, force: np.ndarray, *, position: np.ndarray | None = None, velocity: np.ndarray | None = None,
    normal: np.ndarray | None = None, unit: Literal["m", "rad"] = "m", sign: Literal["auto", 1, -1] = "auto",
    source: str = "arrays",
) -> ForceRecord:  # fmt: skip
    """A record from arrays in SI units; they are not changed.

    Args:
        time: s, rising.
        force: friction force in N (torque in N m where ``unit`` is rad).
        position: m or rad; or
        velocity: m/s or rad/s, or both.
        normal: normal force in N.
        unit: of the position.
        sign: 1 where a positive force resists a positive speed, -1 where it has the other sign; by the work it does.
        source: what a message calls the log.

    Raises:
        DataError: what is wrong with the log, in one sentence.
        ValueRefused: neither position nor velocity, or a sign that is none.
    """
    if position is None and velocity is None:
        raise ValueRefused("position = None, velocity = None: a friction force needs the motion that made it")
    if sign not in ("auto", 1, -1):
        raise ValueRefused(f"sign = {sign!r}: allowed are 'auto', 1 and -1")
    t, f = _row("time", time, source), _row("force", force, source)
    x = None if position is None else _row("position", position, source)
    v = None if velocity is None else _row("velocity", velocity, source)
    n = None if normal is None else _row("normal force", normal, source)
    for name, values in (("force", f), ("position", x), ("velocity", v), ("normal force", n)):
        if values is not None and len(values) != len(t):
            raise DataError(f"{source}: {len(values)} samples of {name}, {len(t)} of time; expected the same number")
    if len(t) < LEAST:
        raise DataError(f"{source}: {len(t)} samples; expected at least {LEAST}")
    findings = check_time(t, source, lambda k: f"sample {k + 1}")
    for name, values in (("force", f), ("position", x), ("velocity", v)):
        if values is not None and np.ptp(values) == 0.0:
            raise DataError(
                f"{source}: the {name} is {values[0]:g} in every sample; expected one that changes: look whether the "
                "right column was named"
            )
    if n is not None:
        n, said = _loaded(n, source)
        findings += said
    if x is None:
        assert v is not None
        x = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
        step, path = 0.0, x
    else:
        x = x - x[0]
        step = encoder_step(x)
        findings += _jumps(t, x, step, unit)
        path = without_flicker(x, step)
    travel, speed = np.diff(path, prepend=path[0]), slopes(t, path, step) if v is None else v
    findings += check_motion(t, f, x, speed, unit, source)
    work, most = float(np.sum(f * travel)), float(np.sum(np.abs(f * travel)))
    if sign == "auto" and abs(work) < NO_WORK * most:
        raise DataError(
            f"{source}: the force does no work on the motion (sum of F dx is {100.0 * work / most:.2g} % of the sum of "
            "its sizes), so it is no friction; look whether the right columns were named, or give --sign"
        )
    turned = sign == -1 or (sign == "auto" and work < 0.0)
    if turned and sign == "auto":
        findings.append(Finding("sign", "note", "the force drives the motion as it stands: its sign was turned"))
    if not (travel > 0.0).any() or not (travel < 0.0).any():
        raise DataError(f"{source}: moves one way only; expected reversals, for friction differs by direction")
    return ForceRecord(
        t, x, travel, speed, -f if turned else f, n, unit, source, turned, step,
        findings,
    )  # fmt: skip


def _row(name: str, values: np.ndarray, source: str) -> np.ndarray:
    row = np.array(values, dtype=float)
    if row.ndim != 1:
        raise DataError(f"{source}: {name} of shape {row.shape}; expected one row of numbers")
    bad = np.flatnonzero(~np.isfinite(row))
    if len(bad):
        raise DataError(f"{source}: {name}, sample {bad[0] + 1}: {row[bad[0]]} is not a finite number")
    return row


def _jumps(t: np.ndarray, x: np.ndarray, step: float, unit: str) -> list[Finding]:
    found, sizes = jumps(x, float(np.median(np.diff(t))), step, 0.0)
    if not len(found):
        return []
    k = int(np.argmax(np.abs(sizes)))
    return [Finding(
        "jump", "warning",
        f"the position jumps {len(found)} time{'s' if len(found) > 1 else ''}, by {sizes[k]:.3g} {unit} at sample "
        f"{found[k] + 1} ({t[found[k]]:.6g} s): a jump of the encoder bends bristles that did not move; leave it out "
        "with --start and --end",
    )]  # fmt: skip


def _loaded(normal: np.ndarray, source: str) -> tuple[np.ndarray, list[Finding]]:
    """The normal force, positive where it presses."""
    if not normal.any():
        raise DataError(f"{source}: the normal force is 0 in every sample; leave the column out, or name the right one")
    if normal.mean() > 0.0:
        return normal, []
    return -normal, [Finding("normal", "note", "the normal force is negative: its sign was turned")]


def encoder_step(x: np.ndarray) -> float:
    """Step that all differences are multiples of; 0 where there is none."""
    sizes = np.abs(np.diff(x))
    floor = 1e-7 * float(np.ptp(x))
    moved = sizes[sizes > floor]
    if len(moved) < 10:
        return 0.0
    step = float(np.quantile(moved, 0.001))
    least = moved[moved < 1.5 * step]
    step = float(np.median(least))
    counts = np.round(moved / step)
    if counts.max() == 1.0 and float(np.mean(sizes[1:][sizes[:-1] > floor] <= floor)) < 0.1:
        return 0.0  # one step at every sample is a constant speed, not a count
    return step if float(np.mean(np.abs(moved / step - counts) < 0.05)) > 0.99 else 0.0


def without_flicker(x: np.ndarray, step: float) -> np.ndarray:
    """The position, where up to two counts against the last direction are held back until a third one comes."""
    if step <= 0.0:
        return x
    at, way, out = float(x[0]), 0.0, []
    for value in x.tolist():
        change = value - at
        if change * way > 0.0 or abs(change) > 2.5 * step:
            at, way = value, 1.0 if change > 0.0 else -1.0
        out.append(at)
    return np.array(out)


def slopes(t: np.ndarray, x: np.ndarray, step: float) -> np.ndarray:
    """Slope over as many samples as a count needs to be 2 % of the usual speed, at least 3."""
    rates = np.abs(np.diff(x) / np.diff(t))
    moving = rates[rates > 0.0]
    usual = float(np.median(moving)) if len(moving) else 0.0
    period = float(np.median(np.diff(t)))
    wide = 3 if usual == 0.0 else int(np.ceil(step / (COUNT_IN_SPEED * usual * period)))
    half = min(max(1, wide // 2), 25)
    k = np.arange(len(x))
    a, b = np.maximum(k - half, 0), np.minimum(k + half, len(x) - 1)
    return (x[b] - x[a]) / (t[b] - t[a])
