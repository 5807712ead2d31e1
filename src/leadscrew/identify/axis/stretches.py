"""The stretches of a log, each simulated from its own measured start, in open loop and in the known closed loop."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.identify.axis.job import Job
from leadscrew.identify.axis.judge import judged
from leadscrew.identify.axis.result import Judged, Parameter
from leadscrew.kernel.errors import DataError

if TYPE_CHECKING:
    from leadscrew.identify.axis.cascade import Cascade


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
    """Positions of each stretch from its own start (:mod:`starts`); None where it diverges."""
    from leadscrew.identify.axis import refine_replay as plant
    from leadscrew.identify.axis.simulation import plant_values, simulate_closed
    from leadscrew.identify.axis.starts import by_model

    if cascade is None and "friction.stiffness" in values:
        from leadscrew.identify.axis.bristles import play_lugre

        return play_lugre(job.log, values, late, [p[1:] for p in parts], job.record.samples.slow_speed)
    if cascade is None:
        point, loop = plant_values(values, job.log.force_per_drive), plant.played(job.log)
        starts = by_model(job.log, loop, point, [first for _, first, _ in parts], late)
        begins = plant.Starts(
            np.array([p[1] for p in parts]), *(np.array(column) for column in zip(*starts, strict=True))
        )
        longest = max(last - first for _, first, last in parts)
        rows = plant.play(loop, [point] * len(parts), begins, longest, [late] * len(parts))
        found = [row[: last - first] for row, (_, first, last) in zip(rows, parts, strict=True)]
        return [None if np.max(np.abs(row)) >= plant.LOST else row for row in found]
    closed: list[np.ndarray | None] = []
    for _, first, last in parts:
        try:
            closed.append(simulate_closed(job.stretch(first, last), values, cascade, late))
        except DataError:
            closed.append(None)
    return closed
