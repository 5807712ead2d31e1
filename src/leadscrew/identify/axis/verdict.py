"""Measured against simulated over a stretch of the log, and what inverse dynamics leaves of its force.

The whiteness of a filtered residual (:func:`leadscrew.identify.estimation.whiteness`) is that of one sample in each
window's length, so that the filter itself does not colour it.

Whether the form of friction fits: what inverse dynamics leaves of the force, by speed and direction.

The residuals of the training part are gathered in bins of speed. Each passage through a bin counts as one observation,
its mean; where the form is right these scatter around 0, and

    t = mean / (s / sqrt(n))        n passages with the standard deviation s

is Student's. A bin in which ``t`` is beyond what all bins together let expect by chance once in a thousand logs, and
whose mean is more than :data:`OF_FRICTION` of the friction there, is friction that the model has no term for. No
interval of a parameter knows of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.identify.axis.inverse_dynamics import SIDES, Terms, friction_key, rows_of, stretches
from leadscrew.identify.axis.job import Job
from leadscrew.identify.axis.record import Record, window
from leadscrew.identify.axis.result import Judged, Parameter
from leadscrew.identify.estimation import whiteness
from leadscrew.identify.log_player import LOST, Starts
from leadscrew.util.errors import DataError

if TYPE_CHECKING:
    from leadscrew.identify.axis.cascade import Cascade


def terms_of(values: Mapping[str, float]) -> Terms:
    """A model all of whose parameters are known, from values by key of the plant."""
    known = {"mass": values["mass"], "offset": values.get("offset", 0.0)}
    falls = []
    for side in SIDES:
        coulomb = values[friction_key(side, "coulomb")]
        static = values.get(friction_key(side, "static"), coulomb)
        known |= {
            friction_key(side, "coulomb"): coulomb,
            friction_key(side, "viscous"): values.get(friction_key(side, "viscous"), 0.0),
            friction_key(side, "excess"): static - coulomb,
        }
        falls.append(values.get(friction_key(side, "stribeck_speed"), 0.0))
    return Terms(False, (falls[0], falls[1]) if min(falls) > 0.0 else None, known)


def force_left(record: Record, values: Mapping[str, float], length: int, delay: float) -> tuple[np.ndarray, np.ndarray]:
    """What the model leaves of the force, and the force, at every sample, both under the window.

    NaN at the edges and where the axis stands or may stand; shape (n,) each.
    """
    rows = rows_of(record, terms_of(values), length, delay, step=1)
    left, force = np.full((2, len(record.position)), np.nan)
    at = rows.at[rows.used]
    left[at], force[at] = rows.force[rows.used], (rows.force + rows.known)[rows.used]
    return left, force


def judged(
    what: str,
    time: np.ndarray,
    record: Record,
    simulated: np.ndarray,
    values: Mapping[str, float],
    length: int,
    delay: float,
) -> Judged:
    """A stretch of the log against its simulation, all of the same length; ``delay`` in periods."""
    left, force = force_left(record, values, length, delay)
    known = np.isfinite(left)
    rms_left = float(np.sqrt(np.mean(left[known] ** 2))) if known.any() else float("nan")
    rms_force = float(np.sqrt(np.mean(force[known] ** 2))) if known.any() else float("nan")
    error = simulated - record.position
    rms = float(np.sqrt(np.mean(error**2)))
    return Judged(
        what=what, start_s=float(time[0]), end_s=float(time[-1]), rms=rms, worst=float(np.max(np.abs(error))),
        nrmse_percent=100.0 * rms / float(np.ptp(record.position)) if np.ptp(record.position) > 0.0 else float("nan"),
        rms_force=rms_left, force_percent=100.0 * rms_left / rms_force if rms_force > 0.0 else float("nan"),
        whiteness=whiteness(left[length // 2 :: length]).percent, time=np.asarray(time),
        measured=np.asarray(record.position), simulated=simulated, speed=speed_of(record), force_left=left,
    )  # fmt: skip


def speed_of(record: Record) -> np.ndarray:
    """Smoothed speed at every sample, shape (n,)."""
    smooth = record.samples.smooth
    return np.concatenate([smooth[:1], smooth, smooth[-1:]])


def extent(record: Record, length: int) -> dict[str, Any]:
    """Top speed and acceleration of a record, and its travel."""
    acceleration = np.convolve(record.samples.acceleration, window(length), "valid")
    return {
        "top_speed": float(np.max(np.abs(speed_of(record)))),
        "top_acceleration": float(np.max(np.abs(acceleration))) if acceleration.size else 0.0,
        "travel": (float(np.min(record.position)), float(np.max(record.position))),
    }


HALF = 50.0
"""Percent of the force, or of the range of the position, that a model of worth does not leave."""


def faults(judged: Sequence[Judged]) -> list[str]:
    """Why the model is worthless, in sentences; judged on validation data where there are any."""
    open_loop = {j.what: j for j in judged if "closed" not in j.what}
    j = open_loop.get("hold-out", open_loop.get("training"))
    where = "the validation data" if "hold-out" in open_loop else "the data of the fit itself"
    if j is None:
        return ["worthless as a model: simulated from the drive alone it diverges"]
    if j.force_percent > HALF:
        return [f"worthless as a model: on {where} it leaves {j.force_percent:.0f} % of the drive's force unexplained"]
    if j.nrmse_percent > HALF:
        return [
            f"worthless for simulation over {j.end_s - j.start_s:.3g} s: on {where} the simulated position is off by "
            f"{j.nrmse_percent:.0f} % of its range"
        ]
    return []


def all_judged(job: Job, table: Mapping[str, Parameter], cascade: Cascade | None) -> list[Judged]:
    """Training, hold-out and whole log in open loop; then in closed loop."""
    values = {key: p.value for key, p in table.items() if key != "delay_s"}
    late, n = table["delay_s"].value, len(job.record.position)
    parts = [("training", 0, job.cut)] + ([("hold-out", job.cut, n), ("whole log", 0, n)] if job.cut < n else [])
    found = []
    for closed in (False, True):
        if closed and (cascade is None or job.log.command is None):
            continue
        positions = simulated(job, values, late, parts, cascade if closed else None)
        for (what, first, last), position in zip(parts, positions, strict=True):
            name, piece = what + (", closed loop" if closed else ""), job.record.part(first, last)
            if position is None:
                job.notes.append(f"{name}: the simulated axis diverges, so it is not judged.")
                continue
            time, delay = job.log.time[first:last], late / job.record.period
            found.append(judged(name, time, piece, position, values, job.length, delay))
    if cascade is not None and job.log.command is None:
        job.notes.append("The log has no command, so the closed loop is not judged.")
    return found


def cascade_left(job: Job, cascade: Cascade | None) -> float | None:
    """Percent of the logged drive that the cascade leaves, from the logged command and position; None without one."""
    from leadscrew.identify.axis.cascade import reproduced

    return None if cascade is None or job.log.command is None else reproduced(job.log, cascade).percent


def simulated(
    job: Job, values: Mapping[str, float], late: float, parts: list[tuple[str, int, int]], cascade: Cascade | None
) -> list[np.ndarray | None]:
    """Positions of each stretch from its own start (``by_model``); None where it diverges."""
    from leadscrew.identify.axis.replay import played
    from leadscrew.identify.axis.simulation import by_model, plant_values, play_lugre, simulate_closed

    if cascade is None and "friction.stiffness" in values:
        return play_lugre(job.log, values, late, [p[1:] for p in parts], job.record.samples.slow_speed)
    if cascade is None:
        point, player = plant_values(values, job.log.force_per_drive), played(job.log)
        begun = by_model(job.log, player, point, [first for _, first, _ in parts], late)
        starts = Starts(np.array([p[1] for p in parts]), *(np.array(column) for column in zip(*begun, strict=True)))
        longest = max(last - first for _, first, last in parts)
        rows = player.play([point] * len(parts), starts, longest, [late] * len(parts))
        found = [row[: last - first] for row, (_, first, last) in zip(rows, parts, strict=True)]
        return [None if np.max(np.abs(row)) >= LOST else row for row in found]
    closed: list[np.ndarray | None] = []
    for _, first, last in parts:
        try:
            closed.append(simulate_closed(job.stretch(first, last), values, cascade, late))
        except DataError:
            closed.append(None)
    return closed


EDGES = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0)
"""Of the bins, as shares of the top speed."""
CHANCE = 1e-3
OF_FRICTION = 0.05
MIN_SAMPLES = 5
"""Passages through a bin that are judged at least."""


class Bin(NamedTuple):
    """Force that the model lacks in a range of speeds, one direction."""

    way: int
    """1 forwards, -1 backwards."""
    slow: float
    fast: float
    mean: float
    """Against the motion: above 0 the axis resists more than the model."""
    error: float
    """Standard error of the mean."""
    passages: int
    lacks: bool


def bins(record: Record, values: Mapping[str, float], length: int, delay: float) -> list[Bin]:
    """All bins with passages enough; ``delay`` in periods."""
    from scipy.stats import t

    left, _ = force_left(record, values, length, delay)
    speed, known = speed_of(record), np.isfinite(left)
    if not known.any():
        return []
    top, found = float(np.max(np.abs(speed[known]))), []
    for way in (1, -1):
        side = "forward" if way > 0 else "backward"
        for low, high in pairwise(EDGES):
            inside = known & (way * speed > low * top) & (way * speed <= high * top)
            means = np.array([way * np.mean(left[a:b]) for a, b in stretches(inside)])
            if len(means) < MIN_SAMPLES:
                continue
            mean, error = float(np.mean(means)), float(np.std(means, ddof=1) / np.sqrt(len(means)))
            friction = values[f"friction.{side}.coulomb"] + values.get(f"friction.{side}.viscous", 0.0) * low * top
            sure = t.isf(0.5 * CHANCE / (2 * (len(EDGES) - 1)), len(means) - 1)
            lacks = abs(mean) > max(float(sure) * error, OF_FRICTION * friction)
            found.append(Bin(way, low * top, high * top, mean, error, len(means), lacks))
    return found


def sentence(found: list[Bin], position_unit: str, force_unit: str) -> str:
    """What the model lacks most in each direction, or nothing."""
    parts = []
    for way, word in ((1, "forwards"), (-1, "backwards")):
        worst = max((b for b in found if b.way == way and b.lacks), key=lambda b: abs(b.mean), default=None)
        if worst is not None:
            more = "more" if worst.mean > 0.0 else "less"
            parts.append(
                f"{word} from {worst.slow:.3g} to {worst.fast:.3g} {position_unit}/s the axis resists by "
                f"{abs(worst.mean):.2g} {force_unit} {more} than the model ({worst.passages} passages, standard error "
                f"{worst.error:.2g})"
            )
    if not parts:
        return ""
    return (
        f"The form of friction does not fit: {' and '.join(parts)}. The intervals are those of this form; "
        "friction, and a delay, may be off by more."
    )
