"""``leadscrew identify servo-gain``: the gain of an integrating plant with known lags, from logs of its moves."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli import pairs
from leadscrew.cli.output import Json, emit, print_table

SCHEMA_VERSION = 1
COLUMNS = ("move", "samples", "gain alone", "misfit %", "travel")


def servo_gain(
    logs: Annotated[
        list[Path], typer.Argument(metavar="LOG...", help="One move a file, or several in one with --split.")
    ],
    input_: Annotated[str, typer.Option("--input", metavar="COLUMN", help="What drives the plant.")] = "output",
    position: Annotated[str, typer.Option(metavar="COLUMN", help="Measured position.")] = "feedback",
    time: Annotated[str, typer.Option(metavar="COLUMN", help="Times, or counts of samples with --unit.")] = "time",
    split: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="A new move begins where this column changes.")
    ] = None,
    lag: Annotated[list[float] | None, typer.Option(metavar="S", help="A known lag; once for each.")] = None,
    hold: Annotated[
        str, typer.Option(help="Input between samples: linear, previous (held), or current (already the later one).")
    ] = "linear",
    unit: Annotated[
        list[str] | None,
        typer.Option(metavar="COLUMN=UNIT", help="Where its header says none; '-190 mm' scales and turns."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Find the gain K of position = K / (s (T1 s + 1) (T2 s + 1) ...) input, and how far the moves agree on it."""
    from leadscrew.identify.linear.servo_gain import servo_gain as fit_all

    found = fit_all(
        logs, input_, position, time=time, split=split, lags_s=lag or (), hold=hold,
        units=pairs.texts("--unit", unit, "COLUMN=UNIT, as in time='0.1 s'"),
    )  # fmt: skip
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "kind": "leadscrew identify servo-gain", **found.as_dict()})
        return
    rows = [
        (m.name, str(m.samples), f"{m.gain_alone:.4g}", f"{m.nrmse_percent:.3g}", f"{m.travel:.4g}")
        for m in found.moves
    ]
    print_table(COLUMNS, rows, right=COLUMNS[1:])
    typer.echo("")
    lags = ", ".join(f"{x:g}" for x in found.lags_s) or "none"
    typer.echo(f"gain {found.gain:.4g} {found.unit}; lags {lags} s; input between samples: {found.hold}")
    typer.echo(f"the moves' own gains differ by {found.spread_percent:.3g} % of it")
    others = ", ".join(f"{name} {value:.4g}" for name, value in found.other_holds.items())
    typer.echo(f"with the input otherwise between samples: {others}")
    if found.notes:
        from leadscrew.cli.door import say

        for note in found.notes:
            say(f"leadscrew: note: {note}")
