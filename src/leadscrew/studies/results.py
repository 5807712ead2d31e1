"""A study evaluated: its claims judged and its experiments run, on all cores, against the numbers it is known to give.

``expected.csv`` in the study's folder holds a row for each number that claims and experiments compute: id, target and
tolerance. A number that leaves its tolerance is a *miss*: ``leadscrew run`` prints it and exits with 1.
"""

from __future__ import annotations

import csv
import io
import math
import os
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from leadscrew.kernel.loop import DivergenceWarning, RunWarning
from leadscrew.kernel.one_thread import one_thread
from leadscrew.studies.claims import Claim, ClaimOf, Value
from leadscrew.studies.exhibits import Experiment, ExperimentOf, FigureOf
from leadscrew.studies.lab import Lab
from leadscrew.study_data import Study
from leadscrew.util import atomic
from leadscrew.util.errors import BlockError, DataError, LeadscrewError, ValueRefused

EXPECTED = "expected.csv"
RELATIVE, ABSOLUTE = 1e-6, 1e-9
"""Tolerance of a new row of ``expected.csv``: above what another processor changes, below what a reader sees."""


class Contents(NamedTuple):
    """What a study claims and shows."""

    claims: list[ClaimOf]
    experiments: list[ExperimentOf]
    figures: list[FigureOf]
    conclusion: Callable[[Lab], list[str]] | None = None
    """The study in about three sentences."""


def contents_of(*places: str | dict[str, Any]) -> Callable[[], Contents]:
    """The claims, experiments and figures of modules (by name, imported when asked for) or of ``globals()``, in order.

    A function of the name ``conclusion`` gives the conclusion.
    """

    def collected() -> Contents:
        spaces = [vars(import_module(place)) if isinstance(place, str) else place for place in places]
        whole = [value for space in spaces for value in space.values()]
        conclusion = next((space["conclusion"] for space in spaces if "conclusion" in space), None)
        return Contents(
            [v for v in whole if isinstance(v, ClaimOf)],
            [v for v in whole if isinstance(v, ExperimentOf)],
            [v for v in whole if isinstance(v, FigureOf)],
            conclusion,
        )

    return collected


class Miss(NamedTuple):
    """A number that is not the expected one."""

    id: str
    value: Value
    target: str
    tolerance: float


@dataclass(frozen=True)
class Results:
    """What came out. The lab keeps the runs and every measure, so that figures draw without a simulation."""

    study: Study
    claims: list[Claim]
    experiments: list[Experiment]
    figures: list[FigureOf]
    conclusion: list[str]
    lab: Lab
    missed: list[Miss] = field(default_factory=list)

    def values(self) -> dict[str, Value]:
        """Every number of claims and experiments, by the id of its row in ``expected.csv``."""
        found: dict[str, Value] = {}
        for claim in self.claims:
            name = claim.id.removeprefix(f"{self.study.name}.")
            found |= {f"{name}/{column}": value for column, value in claim.columns().items()}
        for shown in self.experiments:
            for row, values in shown.table.rows.items():
                cells = zip(shown.table.columns, values, strict=True)
                found |= {f"{shown.name}/{row}/{column}": value for column, value in cells if value is not None}
        return found


def evaluate(
    study: Study, progress: Callable[[str, float], None] = lambda what, done: None, *, key: bool = False
) -> Results:
    """The study's claims judged and its experiments run, side by side on all cores; with ``key`` its key claims alone.

    Raises:
        ValueRefused: the study has no contents, or two claims or experiments have one name.
        BlockError: a claim, an experiment or the conclusion raised an exception.
        DataError: ``expected.csv`` is malformed.
    """
    contents, lab = study.judged(), Lab(study)
    claims = [c for c in contents.claims if c.key or not key]
    experiments = [] if key else contents.experiments
    _check_names(study, [*claims, *experiments])
    with one_thread(), warnings.catch_warnings(), ThreadPoolExecutor(os.cpu_count()) as side_by_side:
        warnings.simplefilter("ignore", DivergenceWarning)
        warnings.simplefilter("ignore", RunWarning)
        judging = {side_by_side.submit(_measured, c.judged, lab): c for c in claims}
        running = {side_by_side.submit(_measured, e.done, lab): e for e in experiments}
        asked: dict[Future[Any], ClaimOf | ExperimentOf] = {**judging, **running}
        try:
            for number, done in enumerate(as_completed(asked), start=1):
                done.result()
                progress(asked[done].name, number / len(asked))
        except BaseException:
            side_by_side.shutdown(cancel_futures=True)
            raise
        judged = [row for done in judging for row in done.result()]
        conclusion = _measured(contents.conclusion, lab) if contents.conclusion else []
    results = Results(study, judged, [done.result() for done in running], contents.figures, conclusion, lab)
    rows, values = expected(study.folder), results.values()
    results.missed.extend(misses(values, rows))
    if not key:
        results.missed.extend(Miss(name, None, *row) for name, row in rows.items() if name not in values)
    return results


def _check_names(study: Study, asked: Sequence[ClaimOf | ExperimentOf]) -> None:
    names = Counter(a.name for a in asked)
    if twice := [name for name, count in names.items() if count > 1]:
        raise ValueRefused(f"{study.name} has more than one claim or experiment of the name {twice[0]}")


def _measured(measure: Callable[[Lab], Any], lab: Lab) -> Any:
    """What a function of the study gives; a fault of it in a sentence that names the function."""
    try:
        return measure(lab)
    except LeadscrewError:
        raise
    except Exception as error:
        name = getattr(getattr(measure, "__self__", measure), "name", getattr(measure, "__name__", "a measure"))
        text = f"{type(error).__name__}: {error}"
        raise BlockError(f"{lab.study.name}: {name} could not be measured: {text}") from error


# ---- expected.csv
def expected(folder: Path) -> dict[str, tuple[str, float]]:
    """Target and tolerance by id; none where the folder has no such file.

    Raises:
        DataError: a row without id, target and a tolerance of 0 or more.
    """
    file = folder / EXPECTED
    if not file.exists():
        return {}
    rows: dict[str, tuple[str, float]] = {}
    with file.open(encoding="utf-8", newline="") as text:
        for line, row in enumerate(csv.DictReader(text), start=2):
            try:
                name, row_value = row["id"], (row["target"], float(row["tolerance"] or 0.0))
            except (KeyError, TypeError, ValueError):
                raise DataError(f"{file}, line {line}: expected id, target and tolerance") from None
            if name in rows or not row_value[1] >= 0.0:
                what = "an id that an earlier line has" if name in rows else "a tolerance below 0"
                raise DataError(f"{file}, line {line}: {what}")
            rows[name] = row_value
    return rows


def misses(values: Mapping[str, Value], rows: Mapping[str, tuple[str, float]]) -> Iterator[Miss]:
    """The values that are not what is expected of them; an id that is not expected is none."""
    for name, value in values.items():
        if name in rows and not _same(value, *rows[name]):
            yield Miss(name, value, *rows[name])


def _same(value: Value, target: str, tolerance: float) -> bool:
    try:
        number = float(target)
    except ValueError:
        return value == target
    if isinstance(value, str) or value is None:
        return False
    if not (math.isfinite(value) and math.isfinite(number)):
        return value == number or (math.isnan(value) and math.isnan(number))
    return abs(value - number) <= tolerance


def write_expected(results: Results) -> Path:
    """Makes what was measured the expectation; a row that is met stays as it is, another one keeps its tolerance."""
    known, file = expected(results.study.folder), results.study.folder / EXPECTED
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(("id", "target", "tolerance"))
    for name, value in results.values().items():
        if name in known and _same(value, *known[name]) and not isinstance(value, str):
            rows.writerow((name, known[name][0], f"{known[name][1]:.1g}"))
        elif isinstance(value, str):
            rows.writerow((name, value, ""))
        else:
            number = float(value or 0.0)
            usual = RELATIVE * abs(number) + ABSOLUTE if math.isfinite(number) else 0.0
            tolerance = known[name][1] if name in known and math.isfinite(known[name][1]) else usual
            rows.writerow((name, repr(number), f"{tolerance:.1g}"))
    atomic.atomic_write(text.getvalue(), file)
    return file
