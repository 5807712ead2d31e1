"""The bench: our loop beside hand-written C, plain Python and other tools, in one process, in medians."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from leadscrew.bench.measuring import FIELDS

PARTS = (
    "threads", "single runs", "batches", "settled loops", "other tools", "inference", "fuzzy systems",
    "stiff friction", "portable functions", "compilation", "fresh processes", "many runs",
    "circular test", "robustness box", "grey prediction", "turning Monte Carlo", "self-organising network",
    "tangential table", "panel",
)  # fmt: skip
"""In this order: threads come first, before the bench itself puts load on the machine."""


def run(
    quick: bool = False, progress: Callable[[str, float], None] | None = None, parts: tuple[str, ...] = PARTS
) -> list[dict[str, Any]]:
    """Measures; one row a comparison, its keys as :data:`FIELDS`. ``quick`` takes fewer rounds and shorter batches.

    Targets are reported, not asserted: ``passed`` is True, False, or None where nothing is judged.
    """
    from leadscrew.bench import (
        circles,
        functions,
        fuzzy,
        grey,
        many,
        measuring,
        operated,
        panel,
        peers,
        robustness,
        servo,
        sofnn,
        stage,
        start,
        tangent,
        threads,
        turning,
    )

    rounds = 3 if quick else 9
    rows = [measuring.row_of_load("before")]
    reference, errors = peers.accuracy(60 if quick else 200)
    made: dict[str, Callable[[], list[dict[str, Any]]]] = {
        "threads": lambda: threads.rows(min(rounds, 5), 1000 if quick else 4000, errors),
        "single runs": lambda: [r for form in servo.INTEGRATORS for r in servo.single_rows(form, rounds, errors)],
        "batches": lambda: servo.batch_rows(rounds, 128 if quick else 512, errors),
        "settled loops": lambda: servo.settled_rows(rounds, errors),
        "other tools": lambda: peers.rows(reference, errors, min(rounds, 5)),
        "inference": lambda: functions.inference_rows(rounds),
        "fuzzy systems": lambda: fuzzy.rows(rounds, quick),
        "stiff friction": lambda: stage.rows(rounds, quick),
        "portable functions": lambda: functions.function_rows(rounds),
        "compilation": lambda: start.compile_rows(1 if quick else 3),
        "fresh processes": lambda: start.rows(min(rounds, 5)),
        "many runs": lambda: many.rows(quick),
        "circular test": lambda: circles.rows(quick),
        "robustness box": lambda: robustness.rows(quick),
        "grey prediction": lambda: grey.rows(rounds),
        "turning Monte Carlo": lambda: turning.rows(quick),
        "self-organising network": lambda: sofnn.rows(rounds),
        "tangential table": lambda: tangent.rows(quick),
        "panel": lambda: [*operated.rows(quick), *panel.rows(quick)],
    }
    for i, part in enumerate(parts):
        if progress is not None:
            progress(part, i / len(parts))
        rows += made[part]()
    return [*rows, measuring.row_of_load("after")]


__all__ = ["FIELDS", "PARTS", "run"]
