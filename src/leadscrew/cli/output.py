"""How every command ends (:func:`deliver`), and its progress bars."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from leadscrew.cli.exit_codes import say

if TYPE_CHECKING:
    from leadscrew.report.report import File, Report


def emit(value: Any) -> None:
    """Exactly one JSON object on stdout; a number that is not finite is ``null``."""
    from leadscrew.util.strict_json import strict

    typer.echo(json.dumps(strict(value), allow_nan=False))


def note(text: str) -> None:
    """A note on stderr."""
    say(f"leadscrew: note: {text}")


def deliver(
    report: Report,
    *,
    out: Path | None = None,
    plot: Path | None = None,
    csv: Path | None = None,
    as_json: bool = False,
) -> None:
    """How a command ends: writes what was asked for, then prints the report, or one JSON object.

    Args:
        report: the result.
        out: folder for its page.
        plot: file for its picture.
        csv: file for its table of all rows.
        as_json: JSON instead; it has the notes too.

    Raises:
        DataError: a file cannot be written.
        typer.Exit: the report has an exit code.
    """
    files = [*_asked(report, out, plot, csv), *report.files]
    for file in files:
        if file.path is not None and file.write is not None:
            file.write(file.path)
    if as_json:
        emit({**report.data, **{f.key: None if f.path is None else str(f.path) for f in files if f.key}})
    else:
        from leadscrew.report import text

        text.show(text.printed(replace(report, files=files), text.width()))
        for line in report.notes:
            note(line)
    if report.code:
        if report.verdict:
            say(f"leadscrew: {report.verdict}")
        raise typer.Exit(report.code)


def _asked(report: Report, out: Path | None, plot: Path | None, csv: Path | None) -> Iterator[File]:
    """What the options name."""
    from leadscrew.report.report import File

    def draw(path: Path) -> None:
        from leadscrew.report.picture import save

        assert report.figure is not None
        save(report.figure(), path)

    def tabulate(path: Path) -> None:
        from leadscrew.util.atomic import atomic_write

        assert report.csv is not None
        atomic_write(report.csv(), path)

    if report.page is not None:
        yield File("report", out, "the report: report.html, picture, JSON", report.page)
    if report.figure is not None:
        yield File("plot", plot, "the picture", draw)
    if report.csv is not None:
        yield File("csv", csv, "all rows", tabulate)


def free(paths: Iterable[Path | None]) -> None:
    """Refuses places where something is already, and such as cannot be written, before the work begins.

    Raises:
        DataError: names the place.
    """
    import tempfile

    from leadscrew.util.errors import DataError

    for path in paths:
        if path is None:
            continue
        try:
            if path.exists() and not (path.is_dir() and not any(path.iterdir())):
                raise DataError(f"{path} exists already; choose another place or remove it")
            path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=path.parent):
                pass
        except OSError as error:
            raise DataError(f"{path} cannot be written: {error.strerror or error}") from None


def write_example(file: Path, content: str | bytes, what: str, next_: str) -> None:
    """Writes an example of the file that a command reads, and says how to go on.

    Raises:
        DataError: the file exists.
    """
    from leadscrew.util.atomic import atomic_write
    from leadscrew.util.errors import DataError

    if file.exists():
        raise DataError(f"{file} exists already; --example overwrites nothing")
    atomic_write(content, file)
    typer.echo(f"{file}: {what}; next: {next_}")


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
