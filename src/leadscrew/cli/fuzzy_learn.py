"""``leadscrew fuzzy learn``: a fuzzy system from logged data, with what the data does not say."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from leadscrew.cli.fuzzy_files import SCHEMA_VERSION
from leadscrew.cli.output import Json, busy, emit
from leadscrew.kernel.errors import ValueRefused


def learn(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="CSV with a header line, or Parquet (by its suffix).")],
    inputs: Annotated[str, typer.Option(metavar="A,B,...", help="Columns of the inputs.")],
    output: Annotated[str, typer.Option(metavar="U", help="Column of the output.")],
    sets: Annotated[
        list[str] | None, typer.Option(metavar="N|NAME=N", help="Sets of every variable, or of one; 7 unless given.")
    ] = None,
    grid: Annotated[
        str | None,
        typer.Option(help="How the inputs' sets lie: even, quantile, or curvature (with --accuracy and --reading)."),
    ] = None,
    accuracy: Annotated[float | None, typer.Option(help="For curvature: in units of the output.")] = None,
    reading: Annotated[str | None, typer.Option(help="Of equation (10): half, full or intervals.")] = None,
    curvature: Annotated[str, typer.Option(help="How curvature is estimated: local or polynomial.")] = "local",
    percentiles: Annotated[
        str, typer.Option(metavar="LOW,HIGH", help="Of the data, where universes begin and end.")
    ] = "0,100",
    symmetric: Annotated[
        bool | None, typer.Option(help="Universes about zero; as the completion needs it unless given.")
    ] = None,
    ties: Annotated[
        str, typer.Option(help="Samples exactly between two sets: drop, or keep (the lower set).")
    ] = "drop",
    weights: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="Column with a weight above 0 to 1 for each sample.")
    ] = None,
    complete: Annotated[
        list[str] | None,
        typer.Option(
            metavar="STEP",
            help="Fill cells without data: monotone, antisymmetric, nearest, servo, servo_growth; repeat for several.",
        ),
    ] = None,
    rising: Annotated[str, typer.Option(metavar="A,B,...", help="Inputs with which the output rises.")] = "",
    falling: Annotated[str, typer.Option(metavar="A,B,...", help="Inputs with which the output falls.")] = "",
    rule_weights: Annotated[str, typer.Option(help="Weights of the rules: none, or strength.")] = "none",
    default: Annotated[
        float | None, typer.Option(metavar="VALUE", help="Of the output, where no rule fires; no value unless given.")
    ] = None,
    hold_out: Annotated[float, typer.Option(help="Part of the samples that only scores, 0 to 0.9.")] = 0.0,
    seed: Annotated[int, typer.Option(help="Which samples are held out.")] = 0,
    name: Annotated[str | None, typer.Option(help="Of the system; the log's stem unless given.")] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="File to write: .fis, .fll or .fcl by its suffix.")
    ] = None,
    most: Annotated[int, typer.Option(help="Lines of a list before it is cut.")] = 60,
    as_json: Json = False,
) -> None:
    """Learn a fuzzy system from a log (Wang and Mendel); says what data covers, what conflicts, what was filled in."""
    from leadscrew.fuzzy import formats
    from leadscrew.fuzzy.from_data import learn as learn_from
    from leadscrew.identify.log import read_columns

    asked = _names("--inputs", inputs)
    if grid is None:
        grid = "even" if accuracy is None and reading is None else "curvature"
    choices: dict[str, Any] = {
        "sets": _sets(sets or [], [*asked, output]), "grid": grid, "accuracy": accuracy, "reading": reading,
        "curvature": curvature, "percentiles": _pair(percentiles), "symmetric": symmetric, "ties": ties,
        "weights": weights, "complete": tuple(complete or []), "directions": _directions(rising, falling),
        "rule_weights": rule_weights, "hold_out": hold_out, "seed": seed, "name": log.stem if name is None else name,
    }  # fmt: skip
    if default is not None:
        choices["default"] = default
    with busy(f"{log}: learning {output} from {', '.join(asked)}"):
        data = read_columns(log, list(dict.fromkeys([*asked, output, *([weights] if weights else [])])))
        learned = learn_from(data, asked, output, **choices)
        notes = formats.write(learned.system, out) if out else ()
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "log": str(log), **learned.as_dict(),
              "out": str(out) if out else None, "notes": list(notes)})  # fmt: skip
        return
    typer.echo(learned.report(most))
    if out:
        typer.echo("\n".join([f"\n{out}: {len(learned.system.rules)} rules written", *notes]))


# ---- options
def _names(option: str, text: str) -> list[str]:
    names = [n.strip() for n in text.split(",")]
    if not all(names):
        raise ValueRefused(f"{option} {text!r}: expected names with commas between them")
    return names


def _sets(texts: list[str], names: list[str]) -> dict[str, int]:
    everywhere, single = 7, {}
    for text in texts:
        name, equals, number = text.rpartition("=")
        try:
            count = int(number)
        except ValueError:
            raise ValueRefused(f"--sets {text!r}: expected a whole number, or NAME=NUMBER") from None
        if equals:
            single[name.strip()] = count
        else:
            everywhere = count
    return {**dict.fromkeys(names, everywhere), **single}


def _pair(text: str) -> tuple[float, float]:
    try:
        low, high = (float(x) for x in text.split(","))
    except ValueError:
        raise ValueRefused(f"--percentiles {text!r}: expected two numbers with a comma between them") from None
    return low, high


def _directions(rising: str, falling: str) -> dict[str, int]:
    up = _names("--rising", rising) if rising else []
    down = _names("--falling", falling) if falling else []
    for name in up:
        if name in down:
            raise ValueRefused(f"--rising and --falling both name {name}")
    return {**dict.fromkeys(up, 1), **dict.fromkeys(down, -1)}
