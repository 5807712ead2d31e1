"""The log of one axis: time, drive and position in SI units, evenly sampled, with what its checks found."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from leadscrew.kernel import validate
from leadscrew.logs import plausible, signals
from leadscrew.logs.finding import Finding, refuse
from leadscrew.logs.measure import encoder_step, motion, noise
from leadscrew.logs.sampling import Place, clock, on_grid
from leadscrew.logs.signals import check_jumps
from leadscrew.util.errors import DataError, ValueRefused, entry_point


class LogUnits(NamedTuple):
    """Units of a log's signals; time is in seconds, velocity in the position's unit a second."""

    position: Literal["m", "rad"]
    drive: str
    """``N``, ``N m``, ``V``, ``A``, ``1``: the drive's own unit stands for the newton where its force is not known."""


@dataclass(frozen=True)
class AxisLog:
    """One axis, logged: arrays of equal length n, read-only, sample k at ``time[k] = time[0] + k period``."""

    time: np.ndarray
    """s."""
    drive: np.ndarray
    """Held from sample to sample; positive drives towards positive position."""
    position: np.ndarray
    """m or rad, measured."""
    command: np.ndarray | None
    """m or rad."""
    velocity: np.ndarray | None
    """m/s or rad/s, as the log has it."""
    period: float
    """s."""
    unit: LogUnits
    source: str
    """The file and its part, or what the arrays were called."""
    findings: list[Finding] = field(default_factory=list)
    force_per_drive: float | None = None
    """N or N m for one unit of the drive, where it was told; the drive itself stays in its own unit."""
    encoder_step: float = 0.0
    """Smallest step of the measured position, m or rad; 0 where its values lie on no grid."""
    noise: float = 0.0
    """Of the measured position, root mean square, m or rad, quantisation included."""

    @property
    def duration(self) -> float:
        """Seconds from the first sample to the last."""
        return float(self.time[-1] - self.time[0])

    def part(self, start: float | None = None, end: float | None = None) -> AxisLog:
        """The samples from ``start`` to ``end``, s, both included; findings are those of the whole log.

        Raises:
            DataError: fewer than three samples lie there.
        """
        slack = 0.01 * self.period
        low = -np.inf if start is None else start - slack
        high = np.inf if end is None else end + slack
        kept = (self.time >= low) & (self.time <= high)
        if kept.sum() < 3:
            raise DataError(
                f"{self.source}: runs from {self.time[0]:g} to {self.time[-1]:g} s; fewer than three samples of it lie "
                f"from {low:g} to {high:g} s"
            )
        cut = {
            name: None if values is None else values[kept]
            for name, values in (
                ("time", self.time), ("drive", self.drive), ("position", self.position), ("command", self.command),
                ("velocity", self.velocity),
            )
        }  # fmt: skip
        return replace(self, **cut)  # type: ignore[arg-type]


@entry_point
def axis_log(
    time: Any,
    drive: Any,
    position: Any,
    command: Any = None,
    velocity: Any = None,
    *,
    position_unit: str = "m",
    drive_unit: str = "N",
    source: str = "arrays",
    force_per_drive: float | None = None,
    lead_mm: float | None = None,
    gear: float = 1.0,
) -> AxisLog:
    """The log of one axis from arrays of equal length; they are copied, never changed.

    ``time`` in seconds. ``position_unit`` (m, mm, um, in, rad, deg, rev) holds for command and velocity too.
    ``lead_mm`` and ``gear`` make a force of a torque: :func:`screw_force`.

    Raises:
        DataError: what is wrong with the log, with its place: unequal lengths, too few samples, values that are no
            numbers, gaps, a clock that jumps, a standstill, jumps of the encoder, units that cannot be.
        ValueRefused: a unit that is not known.
    """
    from leadscrew.logs.units import drive_in, length_in

    kind, scale = length_in(position_unit)
    kept, drive_scale = drive_in(drive_unit)
    given = {"time": time, "drive": drive, "position": position, "command": command, "velocity": velocity}
    sizes = {"time": 1.0, "drive": drive_scale}
    arrays = {role: _copied(role, x, source) * sizes.get(role, scale) for role, x in given.items() if x is not None}
    lengths = {role: len(values) for role, values in arrays.items()}
    if len(set(lengths.values())) > 1:
        raise DataError(
            f"{source}: expected arrays of one length, not {', '.join(f'{r} {n}' for r, n in lengths.items())}"
        )
    unit = LogUnits(kind, kept)  # type: ignore[arg-type]
    log, findings = checked(arrays, unit, source, screw_force(unit, force_per_drive, lead_mm, gear, source))
    refuse(source, findings)
    assert log is not None
    return log


def screw_force(
    unit: LogUnits, force_per_drive: float | None, lead_mm: float | None, gear: float, source: str
) -> float | None:
    """N for one unit of the drive, of a motor that turns a screw without losses: ``2 pi gear / lead`` for 1 N m.

    ``lead_mm``: travel of one revolution of the screw; None: ``force_per_drive`` is N for one unit as it is. With it,
    ``force_per_drive`` is the motor's N m for one unit, 1 of a drive in N m. ``gear``: revolutions of the motor for one
    of the screw.

    Raises:
        ValueRefused: a lead or gear that is not above 0, a gear without a lead, or a lead where nothing is to convert.
    """
    gear = validate.positive("gear", gear, "")
    if lead_mm is None:
        if gear != 1.0:
            raise ValueRefused(f"gear = {gear:g}: needs the lead of the screw too, --lead in mm")
        return force_per_drive
    lead = 1e-3 * validate.positive("lead", lead_mm, "mm")
    if unit.position != "m" or unit.drive == "N":
        why = "the drive is a force" if unit.drive == "N" else "the position is an angle"
        raise ValueRefused(f"{source}: lead = {lead_mm:g} mm: {why}, so no torque is converted; leave --lead out")
    if unit.drive != "N m" and force_per_drive is None:
        raise ValueRefused(
            f"{source}: lead = {lead_mm:g} mm: the drive is in {'no unit' if unit.drive == '1' else unit.drive}; if it "
            "is a torque, say --unit 'drive=N m', else give --force-per-drive, the motor's N m for one unit of it"
        )
    return (1.0 if force_per_drive is None else force_per_drive) * 2.0 * math.pi * gear / lead


def unlike(unit: LogUnits) -> str:
    """What is missing where a torque moves a length, or a force an angle; empty where the two go together."""
    if unit == ("m", "N m"):
        return (
            "the drive is a torque in N m, the position a length: give the lead of the screw, --lead MM (and --gear), "
            "or --force-per-drive, N for 1 N m"
        )
    if unit == ("rad", "N"):
        return "the drive is a force in N, the position an angle: give --force-per-drive, N m for 1 N"
    return ""


def checked(
    arrays: dict[str, np.ndarray],
    unit: LogUnits,
    source: str,
    force_per_drive: float | None = None,
    place: Place | None = None,
    lost: Sequence[int] = (),
) -> tuple[AxisLog | None, list[Finding]]:
    """The log from arrays in SI, where one can be made, and all findings, for those who want more than one refusal.

    ``place`` names a sample for a message, ``lost`` are samples before which the recorder lost some.
    """
    where = place or (lambda k: f"sample {k + 1}")
    few = signals.check_rows(len(arrays["time"]))
    if bad := [f for f in (*few, *signals.check_numbers(arrays, where)) if f.severity == "refused"]:
        return None, bad
    step = encoder_step(arrays["position"])
    fixed = signals.check_constant(arrays, step)
    stamps = clock(arrays["time"], where, lost)
    findings = [*fixed, *few, *stamps.findings]
    if stamps.time is None:
        return None, findings
    with np.errstate(all="ignore"):
        findings += _moving(arrays, stamps.period, unit, force_per_drive, step, where)
    findings += signals.check_clipped(arrays["drive"], arrays["time"], where)
    if stamps.scattered:
        arrays = {
            r: x if r == "time" else on_grid(arrays["time"], stamps.time, x, r == "drive") for r, x in arrays.items()
        }
    frozen = {role: _frozen(values) for role, values in arrays.items()}
    log = AxisLog(
        time=_frozen(stamps.time), drive=frozen["drive"], position=frozen["position"], command=frozen.get("command"),
        velocity=frozen.get("velocity"), period=stamps.period, unit=unit, source=source, findings=findings,
        force_per_drive=force_per_drive, encoder_step=step, noise=noise(arrays["position"], step),
    )  # fmt: skip
    return log, findings


def _moving(
    arrays: dict[str, np.ndarray],
    period: float,
    unit: LogUnits,
    force_per_drive: float | None,
    step: float,
    place: Place,
) -> list[Finding]:
    """What is wrong with the signals together, worst first."""
    position, command, velocity = arrays["position"], arrays.get("command"), arrays.get("velocity")
    if not np.ptp(position):
        return []
    scale = (step, noise(position, step))
    if stands := signals.check_motion(position, scale[1], period):
        return stands
    found = check_jumps(arrays["time"], position, arrays["drive"], command, scale, unit.position, place)
    moves = motion(position, period)
    known = 1.0 if unit in (("m", "N"), ("rad", "N m")) else None
    found += plausible.check_drive(arrays, moves, period, unit.position, force_per_drive or known)
    if command is not None:
        found += plausible.check_command(position, command, period)
    if velocity is not None:
        found += plausible.check_velocity(moves, velocity)
    return found + plausible.check_units(position, moves, period, unit.position)


def _copied(role: str, values: Any, source: str) -> np.ndarray:
    try:
        array = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise DataError(f"{source}: {role} is not an array of numbers") from None
    if array.ndim != 1 and array.size != max(array.shape, default=0):
        raise DataError(f"{source}: {role} has the shape {array.shape}; expected one row or one column of numbers")
    return array.reshape(-1)


def _frozen(values: np.ndarray) -> np.ndarray:
    values = np.array(values, dtype=float)
    values.flags.writeable = False
    return values
