"""``leadscrew demo``: the first study, start to end."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.output import Json
from leadscrew.cli.run import judged, leave

STUDY = "vud_lathe"


def demo(
    out: Annotated[Path | None, typer.Option(help=f"Folder of the report; report/{STUDY} unless given.")] = None,
    as_json: Json = False,
) -> None:
    """Run the lathe study: every claim of the paper beside our number."""
    if not as_json:
        typer.echo(f"leadscrew run {STUDY}\n")
    result, folder, wall = judged(STUDY, out, figures=True, as_json=as_json)
    if not as_json:
        typer.echo(f"\nThe whole demo took {wall:.1f} s. Open the report, it needs no network:")
        typer.echo(f"  {(folder / 'report.html').resolve()}")
        typer.echo("Then try:")
        typer.echo(f"  leadscrew list {STUDY}")
        typer.echo(
            f"  leadscrew simulate {STUDY} --controller corrected.vud_beta_e --scenario fig11a_step_m50 "
            "--set scenario.target_mm=-120"
        )
    leave(result)
