"""Options that several commands have: one name, one meaning, one check."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from leadscrew.util.errors import ValueRefused

PICTURES = (".png", ".svg", ".pdf")
"""Suffixes of pictures."""


def suffix_of(path: Path, allowed: Sequence[str], option: str) -> str:
    """The suffix of a file that is to be written.

    Raises:
        ValueRefused: another suffix.
    """
    suffix = path.suffix.casefold()
    if suffix not in allowed:
        raise ValueRefused(f"{option} {path}: {suffix or 'no suffix'}: allowed are {', '.join(allowed)}")
    return suffix


def ends(option: str, what: str, *allowed: str) -> Callable[[Path | None], Path | None]:
    """The check of an option that names a file of a kind."""

    def checked(value: Path | None) -> Path | None:
        if value is not None and value.suffix.casefold() not in allowed:
            raise ValueRefused(f"{option} {value}: {what} ends in {', '.join(allowed)}")
        return value

    return checked


def _trusted(ctx: typer.Context, value: bool) -> None:
    """Opens :func:`leadscrew.trust` until the command ends."""
    if value:
        from leadscrew.userfile import trust

        ctx.with_resource(trust())


# ---- every command
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")]
Trust = Annotated[
    bool,
    typer.Option(
        "--trust",
        callback=_trusted,
        expose_value=False,
        help="Run Python outside the working folder that a file names; read it first.",
    ),
]
"""Every command has it whose files can name Python; its value is spent before the command begins."""

# ---- the loop
StudyName = Annotated[
    str,
    typer.Argument(
        metavar="STUDY", help="A study's name, path/file.py:NAME, or an experiment or machine file (.toml)."
    ),
]
LoopName = Annotated[
    str,
    typer.Argument(
        metavar="STUDY",
        help="A study's name; path/file.py:NAME of a study, a Loop or a function that returns one; "
        "or a machine or experiment file (.toml).",
    ),
]
Controller = Annotated[
    str | None,
    typer.Option(
        "--controller",
        "-c",
        help="Of the study, of the catalogue, path/file.py:NAME, a fuzzy system's file, or a controller file (.toml).",
    ),
]
Scenario = Annotated[
    str | None, typer.Option("--scenario", "-s", help="What is asked of the machine (default: the study's first).")
]
Scenarios = Annotated[
    list[str] | None,
    typer.Option("--scenario", "-s", help="What is asked of the machine (default: the study's first). Repeat."),
]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a parameter; leadscrew list STUDY shows them. Repeat."),
]
Duration = Annotated[float | None, typer.Option(metavar="S", help="Duration in seconds (default: the scenario's).")]
Engine = Annotated[str | None, typer.Option(help="What runs the loop (default: the fastest).")]

# ---- many runs
Over = Annotated[
    list[str] | None,
    typer.Option(
        metavar="KEY=DIST",
        help="What differs from plant to plant: LOW:HIGH, LOW:HIGH:log, LOW:HIGH:int, normal:MEAN:DEVIATION, "
        "lognormal:MEDIAN:FACTOR, A|B|C, or intervals: of a machine file. Repeat.",
    ),
]
Goals = Annotated[
    list[str] | None,
    typer.Option(
        "--minimise", metavar="METRIC", help="Worst case; also mean:, median:, p95: before, @SCENARIO after. Repeat."
    ),
]
Constraints = Annotated[
    list[str] | None, typer.Option("--subject-to", metavar="'METRIC<=VALUE'", help="To be kept; also >=. Repeat.")
]
Plants = Annotated[int | None, typer.Option(metavar="N", help="That the search sees; 16 with --over.")]
Budget = Annotated[
    int, typer.Option(metavar="N", help="Settings to try, at most; each on all its plants and scenarios.")
]
Optimiser = Annotated[
    str | None,
    typer.Option(help="cma, de, nsga2 or scipy (default: cma for one goal and nsga2 for several)."),
]
Threads = Annotated[int | None, typer.Option(metavar="N", help="Threads (default: all cores).")]
Cluster = Annotated[
    str | None, typer.Option(metavar="WHERE", help="The same runs on Dask workers: local:N or tcp://HOST:PORT.")
]
Journal = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        help="Folder for results as they come, kept afterwards (default: beside the output, removed at the end).",
    ),
]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with what the journal holds.")]

# ---- logs
Log = Annotated[
    Path, typer.Argument(metavar="LOG", help="CSV, Parquet, or a folder of simulate --out; evenly sampled.")
]
TimeColumn = Annotated[
    str, typer.Option("--time", metavar="COLUMN", help="Times; in s unless the header names a unit.")
]
From = Annotated[float | None, typer.Option("--from", metavar="S", help="Leave out what is before.")]
To = Annotated[float | None, typer.Option("--to", metavar="S", help="Leave out what is after.")]
Start = Annotated[float | None, typer.Option("--start", metavar="S", help="Leave out what is before.")]
End = Annotated[float | None, typer.Option("--end", metavar="S", help="Leave out what is after.")]
Columns = Annotated[
    list[str] | None,
    typer.Option("--column", metavar="ROLE=HEADER", help="Column of a role (default: by its header). Repeat."),
]
Units = Annotated[
    list[str] | None,
    typer.Option(
        "--unit", metavar="ROLE=UNIT", help="Unit of a column, over the file's own: mm, ms, '5e-8 m'. Repeat."
    ),
]
Period = Annotated[
    float | None, typer.Option(metavar="S", help="Sampling period, for a log without a column of times.")
]
Lead = Annotated[
    float | None,
    typer.Option(
        metavar="MM",
        help="Travel of one screw revolution: a drive in N m becomes a force, without losses; --force-per-drive is "
        "then the motor's N m for one unit of the drive.",
    ),
]
Gear = Annotated[float, typer.Option(metavar="N", help="With --lead: motor revolutions for one of the screw.")]
Level = Annotated[float, typer.Option(metavar="P", help="Level of the confidence intervals.")]

# ---- what is written
Folder = Annotated[
    Path | None, typer.Option("--out", "-o", metavar="DIR", help="Folder for the report: page, picture, JSON.")
]
Plot = Annotated[
    Path | None,
    typer.Option(
        "--plot",
        metavar="FILE",
        help="Also draw it: .png, .svg or .pdf.",
        callback=ends("--plot", "a picture", *PICTURES),
    ),
]


def _file(flags: Sequence[str], suffix: str, what: str, text: str) -> Any:
    """An option for one file that is written, ``what`` with ``suffix``."""
    return typer.Option(*flags, metavar=f"FILE{suffix}", help=text, callback=ends(flags[0], what, suffix))


OUT = ("--out", "-o")
Csv = Annotated[Path | None, _file(["--csv"], ".csv", "a table", "Also write all rows there.")]
ControllerFile = Annotated[
    Path | None, _file(OUT, ".toml", "a controller file", "Controller file: a name wherever a controller is named.")
]
MachineFile = Annotated[
    Path | None, _file(OUT, ".toml", "a machine file", "Machine file: a name wherever a study is named.")
]
Certificate = Annotated[Path | None, _file(OUT, ".json", "a certificate", "Save the certificate.")]
Example = Annotated[
    bool, typer.Option("--example", help="Write an example of such a file there instead, to see what it is like.")
]
