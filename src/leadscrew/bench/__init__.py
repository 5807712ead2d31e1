"""The bench: our loop beside hand-written C, plain Python and other tools, in one process, in medians."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from leadscrew.bench.row import FIELDS

PARTS = ("single runs", "batches", "settled loops", "other tools", "inference", "portable functions", "fresh processes")


def run(
    quick: bool = False, progress: Callable[[str, float], None] | None = None, parts: tuple[str, ...] = PARTS
) -> list[dict[str, Any]]:
    """Measures; one row a comparison, its keys as :data:`FIELDS`. ``quick`` takes fewer rounds and shorter batches."""
    from leadscrew.bench import functions, others, servo, start

    rounds = 3 if quick else 9
    reference, errors = others.accuracy(60 if quick else 200)
    made: dict[str, Callable[[], list[dict[str, Any]]]] = {
        "single runs": lambda: [r for form in servo.INTEGRATORS for r in servo.single_rows(form, rounds, errors)],
        "batches": lambda: servo.batch_rows(rounds, quick),
        "settled loops": lambda: servo.settled_rows(rounds),
        "other tools": lambda: others.rows(reference, errors, min(rounds, 5)),
        "inference": lambda: functions.inference_rows(rounds),
        "portable functions": lambda: functions.function_rows(rounds),
        "fresh processes": lambda: start.rows(min(rounds, 5)),
    }
    rows: list[dict[str, Any]] = []
    for i, part in enumerate(parts):
        if progress is not None:
            progress(part, i / len(parts))
        rows += made[part]()
    return rows


__all__ = ["FIELDS", "PARTS", "run"]
