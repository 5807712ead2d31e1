"""What the commands print: strict JSON, tables, progress."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from leadscrew.report.report import Report

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")]
"""The option that every command with a result has."""


def emit(value: Any) -> None:
    """Exactly one JSON object on stdout; a number that is not finite is ``null``."""
    from leadscrew.util.strict_json import strict

    typer.echo(json.dumps(strict(value), allow_nan=False))


def deliver(
    report: Report,
    page: Path,
    wall_s: float,
    *,
    everything: bool = False,
    as_json: bool = False,
    notes: Sequence[str] = (),
) -> None:
    """How a command ends: prints its report, or that as JSON; exit code 1 when an expected number is missed.

    ``page``: where the report was written; ``everything``: all tables, not the summary alone.
    """
    if as_json:
        from leadscrew.report.folder import data

        emit(data(report, wall_s, page))
    else:
        from leadscrew.report import text

        columns = text.width()
        lines = text.whole(report, columns) if everything else text.summary(report, columns)
        text.show([*lines, *text.ending(notes, page, wall_s, columns)])
    if report.missed:
        from leadscrew.cli.exit_codes import MISSED

        raise typer.Exit(MISSED)


def width() -> int:
    """Columns that a table may take."""
    from leadscrew.report.text import console

    return console().width


MOST_ROWS = 2000
"""Of a table that is printed: Rich takes some milliseconds a row."""


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str]], right: Sequence[str] = ()) -> None:
    """A table; texts are taken literally, ``right`` names the columns of numbers; beyond 2,000 rows only how many."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from leadscrew.report.text import console

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.show_edge = False
    for name in columns:
        # What stands first is a name to copy: never broken.
        first = name == columns[0]
        table.add_column(Text(name), justify="right" if name in right else "left", overflow="fold", no_wrap=first)
    rows = list(rows)
    for row in rows[:MOST_ROWS]:
        table.add_row(*(Text(str(cell), style=STYLES.get(str(cell), "")) for cell in row))
    out = console()
    if not out.is_terminal:
        # Rich pads every line to the width of the table; a pipe does not need that.
        with out.capture() as held:
            out.print(table)
        typer.echo("\n".join(line.rstrip() for line in held.get().splitlines()))
    else:
        out.print(table)
    if len(rows) > MOST_ROWS:
        typer.echo(f"... and {len(rows) - MOST_ROWS} more; --json prints all")


STYLES = {
    "reproduced": "green",
    "reproduced with change": "blue",
    "not reproduced": "red",
    "cannot be checked": "dim",
    "NO": "bold red",
}
"""Words that a terminal shows in colour; the words themselves always stand there."""


@contextmanager
def progress() -> Iterator[Callable[[str, float], None]]:
    """A progress bar on stderr, gone when done; give it what happens now and the fraction done."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    err = Console(stderr=True)
    columns = (BarColumn(bar_width=30), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as bar:
        task = bar.add_task("starting", total=None)

        def report(what: str, done: float) -> None:
            bar.update(task, description=what, completed=done, total=1.0)

        yield report


@contextmanager
def busy(what: str) -> Iterator[None]:
    """A moving bar with the time elapsed, on stderr, around work that cannot say how far it is."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    err = Console(stderr=True)
    columns = (BarColumn(bar_width=30), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as bar:
        bar.add_task(what, total=None)
        yield
