"""A bar for many runs: how many of all, runs a second, time that remains."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Report = Callable[[int, int], None]
Stage = Callable[[str], Report]


@contextmanager
def counting() -> Iterator[Stage]:
    """A bar on stderr, gone when done; give it the name of a stage and take what reports runs done and all runs."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    err = Console(stderr=True)
    columns = (
        BarColumn(bar_width=30), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"), TimeRemainingColumn(),
        TextColumn("{task.description}", markup=False),
    )  # fmt: skip
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as bar:

        def stage(what: str) -> Report:
            for task in bar.task_ids:
                bar.remove_task(task)
            task = bar.add_task(what, total=None, rate="")
            began, kept = time.perf_counter(), -1

            def report(done: int, total: int) -> None:
                nonlocal began, kept
                if kept < 0:
                    # What a journal had already is no work of ours.
                    began, kept = time.perf_counter(), done
                seconds = time.perf_counter() - began
                rate = f"{(done - kept) / seconds:,.0f} runs/s" if done > kept and seconds > 0.0 else ""
                bar.update(task, completed=done, total=total, rate=rate)

            return report

        yield stage
