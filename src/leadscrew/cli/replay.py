"""``leadscrew replay``: the same bits again, or where they part."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.door import MISSED
from leadscrew.cli.output import Json, busy, emit


def replay(
    folder: Annotated[Path, typer.Argument(metavar="RUN", help="A run folder, or the run.json in it.")],
    as_json: Json = False,
) -> None:
    """Run a saved run again and compare it bit for bit.

    Exit code 0 only if it is identical.
    """
    from leadscrew.replay import replay as again

    with busy(f"replaying {folder}"):
        found = again(folder)
    if as_json:
        emit(
            {
                "run": str(found.folder),
                "identical": found.identical,
                "first_difference": found.difference or None,
                "changed_since": list(found.causes),
                "rows": found.rows,
                "signals": list(found.signals),
                "wall_s": found.wall_s,
            }
        )
    elif found.identical:
        typer.echo(f"identical: {found.rows} rows of {len(found.signals)} signals, bit for bit")
    else:
        typer.echo(f"not identical: {found.difference}")
        for cause in found.causes:
            typer.echo(f"  changed since: {cause}")
    if not found.identical:
        raise typer.Exit(MISSED)
