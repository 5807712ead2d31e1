"""The report of ``leadscrew log``: columns, sampling, and what is wrong with a log."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from leadscrew.figures.table import number, unit
from leadscrew.logs.summary import MOST_WORDS, Column, as_dict, columns_of, sentences
from leadscrew.report.report import Report, TextTable, head

if TYPE_CHECKING:
    from leadscrew.logs.axis_file import Seen
    from leadscrew.logs.finding import Finding
    from leadscrew.logs.table import Table

REFUSED = 2
SEVERITIES = ("refused", "warning", "note")
"""Of findings, the gravest first."""


def report_of(file: Path, table: Table, seen: Seen | None, findings: Sequence[Finding]) -> Report:
    """The report; its exit code is 2 where the log is refused."""
    rows = [
        [c.name, unit(c.unit), c.role, *_range(c)] for c in columns_of(table, None if seen is None else seen.columns)
    ]
    constants = ", ".join(f"{name} = {value:.8g}" for name, value in table.constants.items())
    ranked = sorted(findings, key=lambda f: SEVERITIES.index(f.severity))
    return Report(
        {**head("log"), **as_dict(table, seen), "findings": [f._asdict() for f in findings]},
        parts=[
            f"{file}: {table.form}, {table.rows} rows",
            *table.notes,
            TextTable(("column", "unit", "role", "from", "to", ""), rows, [False, False, False, True, True, False]),
            *([f"constants: {constants}"] if constants else []),
            *([] if seen is None else sentences(seen)),
            *(f"{f.severity}: {f.sentence}" for f in ranked),
            *([] if findings else ["nothing is wrong with it that shows in a log"]),
        ],
        code=REFUSED if any(f.severity == "refused" for f in findings) else 0,
    )


def _range(c: Column) -> tuple[str, str, str]:
    """Smallest and largest value, and what else there is to say."""
    empty = f", {c.missing} without a value" if c.missing else ""
    if c.kind == "words":
        more = ", ..." if len(c.words) > MOST_WORDS else ""
        return "", "", f"words: {', '.join(c.words[:MOST_WORDS])}{more}{empty}"
    if c.low is None or c.high is None:
        return "", "", f"no value{empty}"
    ends = number(c.low, 6), number(c.high, 6)
    if c.kind == "constant":
        return *ends, f"constant{empty}"
    return *ends, (f"steps of {number(c.step)}" if c.step else "") + empty
