"""``leadscrew fuzzy``: fuzzy systems in files, shown, converted, evaluated, drawn, learned from data, measured."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.fuzzy_files import (
    LeaveOut,
    SystemFile,
    columns_of,
    known,
    number_of,
    numbers,
    pairs,
    save_table,
    system_of,
    table_of,
    text_table,
)
from leadscrew.cli.options import PICTURES, Json, Plot, suffix_of
from leadscrew.cli.output import busy, deliver
from leadscrew.figures.table import fixed, number, unit
from leadscrew.report.picture import save
from leadscrew.report.report import File, Lines, Part, Report, TextTable, Verbatim, head
from leadscrew.util.errors import DataError, LeadscrewError, NameUnknown, ValueRefused

if TYPE_CHECKING:
    import numpy as np

    from leadscrew.fuzzy.explanation import Use
    from leadscrew.fuzzy.system import System


# ---- show
def show(
    file: SystemFile,
    plot: Plot = None,
    leave_out_unknown: LeaveOut = False,
    as_json: Json = False,
) -> None:
    """Show what is in a file: variables, terms, rules, norms, and how the system is evaluated."""
    from leadscrew.report.fuzzy.system import report_of

    deliver(report_of(file, system_of(file, leave_out_unknown)), plot=plot, as_json=as_json)


# ---- convert
def convert(
    source: Annotated[Path, typer.Argument(metavar="FROM", help="A fuzzy system: .fis, .fll, .fcl or .xml.")],
    target: Annotated[Path, typer.Argument(metavar="TO", help="The file to write: .fis, .fll or .fcl.")],
    force: Annotated[bool, typer.Option("--force", help="Replace the file if it exists.")] = False,
    leave_out_unknown: LeaveOut = False,
    as_json: Json = False,
) -> None:
    """Write a system in another format, and say what that format cannot express."""
    from leadscrew.fuzzy import formats

    suffix_of(target, [f".{f}" for f in formats.WRITTEN], "TO")
    if target.exists() and not force:
        raise ValueRefused(f"{target} exists already; --force replaces it")
    system = system_of(source, leave_out_unknown)
    lost = formats.write(system, target)
    report = Report(
        {**head("fuzzy convert"), "from": str(source), "to": str(target), "name": system.name,
         "rules": len(system.rules), "read": list(system.notes), "not_said": list(lost)},
        parts=[
            f"{target}: {system.name or source.stem}, {len(system.rules)} rules",
            *(f"read: {line}" for line in system.notes),
            *(f"not in this format: {line}" for line in lost),
        ],
    )  # fmt: skip
    deliver(report, as_json=as_json)


def eval_(
    file: SystemFile,
    values: Annotated[
        list[str] | None, typer.Argument(metavar="INPUT=VALUE", help="A value for every input: e=0.1 de=-0.2.")
    ] = None,
    explain: Annotated[bool, typer.Option("--explain", help="Also say which rules fire and what each does.")] = False,
    points: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A .csv or .parquet whose columns are the inputs.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="Where to write the table: .csv or .parquet.")
    ] = None,
    engine: Annotated[str, typer.Option(help="llvm, c or python.")] = "llvm",
    leave_out_unknown: LeaveOut = False,
    as_json: Json = False,
) -> None:
    """Evaluate a system at a point, or at all points of a file."""
    from leadscrew.kernel.engines import ENGINES

    known(engine, ENGINES, "engine")
    if points is None:
        if out is not None:
            raise ValueRefused(f"--out {out}: a table comes from --points FILE only")
        _at_point(file, system_of(file, leave_out_unknown), values or [], explain, engine, as_json)
        return
    if values or explain:
        raise ValueRefused("--points takes its values from a file: no INPUT=VALUE and no --explain")
    if out is not None:
        suffix_of(out, (".csv", ".parquet"), "--out")
    _at_points(file, system_of(file, leave_out_unknown), points, out, engine, as_json)


def _at_point(file: Path, system: System, values: list[str], explain: bool, engine: str, as_json: bool) -> None:
    from leadscrew.fuzzy.evaluate import compiled
    from leadscrew.fuzzy.explanation import explain as explained

    inputs = numbers(values, "")
    with busy(f"{system.name} on {engine}"):
        outputs = compiled(system, engine)(**inputs)
    why = explained(system, inputs) if explain else None
    values_of = Lines(f"{o.name} = {outputs[o.name]!r} {o.unit}".rstrip() for o in system.outputs)
    report = Report(
        {**head("fuzzy eval"), "file": str(file), "system": system.name, "engine": engine, "inputs": inputs,
         "outputs": outputs, "units": {o.name: o.unit for o in system.outputs},
         "explanation": None if why is None else why.as_dict()},
        parts=[values_of if why is None else Lines(str(why).splitlines())],
    )  # fmt: skip
    deliver(report, as_json=as_json)


def _at_points(file: Path, system: System, points: Path, out: Path | None, engine: str, as_json: bool) -> None:
    import numpy as np

    from leadscrew.fuzzy.evaluate import compiled

    names = [v.name for v in system.inputs]
    with busy(f"{points}: {system.name} on {engine}"):
        given = table_of(points, names)
        x = np.column_stack([given[n] for n in names])
        y = compiled(system, engine).many(x).reshape(len(x), -1)
        outputs = [o.name for o in system.outputs]
        if out is not None:
            save_table([*names, *outputs], np.column_stack([x, y]), out)
    columns = {n: y[:, i] for i, n in enumerate(outputs)} if out is None else None
    report = Report(
        {**head("fuzzy eval"), "file": str(file), "system": system.name, "engine": engine, "points": len(x),
         "outputs": columns},
        parts=[Verbatim(text_table([*names, *outputs], np.column_stack([x, y])).splitlines())] if out is None else [],
        files=[File("out", out, f"{len(x)} points, {', '.join(outputs)}")],
    )  # fmt: skip
    deliver(report, as_json=as_json)


COLUMNS = ("name", "what", "value", "unit", "ratio", "remark")


def bench(
    file: SystemFile,
    points: Annotated[int, typer.Option(metavar="N", help="How many points are evaluated.")] = 100_000,
    leave_out_unknown: LeaveOut = False,
    as_json: Json = False,
) -> None:
    """Measure how fast a system is evaluated, on every engine and beside other programs."""
    if not 1 <= points <= 100_000_000:
        raise ValueRefused(f"--points {points}: allowed are 1 to 100000000")
    system = system_of(file, leave_out_unknown)
    try:
        measure = import_module("leadscrew.bench.fuzzy").bench_file
    except ImportError as error:
        raise LeadscrewError(f"the benchmarks are not in this installation ({error})") from None
    with busy(f"{system.name}, {points} points"):
        rows: list[dict[str, Any]] = measure(system, points)
    cells = [["" if row.get(c) in (None, "") else unit(number(row[c])) for c in COLUMNS] for row in rows]
    data = {**head("fuzzy bench"), "file": str(file), "system": system.name, "points": points, "rows": rows}
    deliver(Report(data, [TextTable(COLUMNS, cells)]), as_json=as_json)


_FUNCTION = re.compile(r"(change|rate)\((.+)\)")


@dataclass(frozen=True)
class Source:
    """Where an input comes from: ``scale * function(column)``."""

    column: str
    scale: float = 1.0
    function: str = ""

    def values(self, column: np.ndarray, time: np.ndarray) -> np.ndarray:
        """The input; its first change is zero, as nothing was before."""
        import numpy as np

        if self.function:
            column = np.diff(column, prepend=column[:1])
        if self.function == "rate" and len(time) > 1:
            column = column / np.append(1.0, np.diff(time))
        return self.scale * column


@dataclass(frozen=True)
class RunInputs:
    """The inputs of a system along a run."""

    time: np.ndarray
    unit: str
    """Of the times; empty where they are numbers of rows."""
    points: np.ndarray
    sources: dict[str, str]
    """Where each input was taken from."""


def source_of(text: str, name: str) -> Source:
    """A source from ``COLUMN``, ``SCALE*COLUMN``, ``change(COLUMN)`` or ``SCALE*rate(COLUMN)``.

    Raises:
        ValueRefused: what stands before the star is no number.
    """
    before, star, after = text.partition("*")
    scale = number_of(before.strip(), f"--map {name}: scale") if star else 1.0
    column = (after if star else before).strip()
    match = _FUNCTION.fullmatch(column)
    return Source(match[2].strip(), scale, match[1]) if match else Source(column, scale)


def recorded_inputs(run: Path, inputs: Sequence[str], maps: Sequence[str], time: str | None) -> RunInputs:
    """The inputs along a run; a column of an input's own name unless ``maps`` say otherwise.

    Raises:
        NameUnknown: no such input.
        ValueRefused: a map that is none.
        DataError: the run cannot be read, a column is missing, a cell is no number, or the times do not rise.
    """
    import numpy as np

    path = run / "signals.parquet" if run.is_dir() else run
    given = pairs(maps, "--map")
    for name in given:
        known(name, inputs, "input")
    sources = {name: source_of(given.get(name, name), name) for name in inputs}
    there = columns_of(path)
    lost = [n for n in inputs if n not in given and n not in there]
    if lost:
        raise NameUnknown(
            f"{path} has no column {lost[0]!r} for the input {lost[0]}; say where it comes from: "
            f"--map {lost[0]}=COLUMN, columns are {', '.join(there)}"
        )
    clock = time if time is not None else "time" if "time" in there else None
    wanted = dict.fromkeys([*([] if clock is None else [clock]), *(s.column for s in sources.values())])
    table = table_of(path, list(wanted))
    rows = len(next(iter(table.values())))
    t = table[clock] if clock is not None else np.arange(1.0, rows + 1.0)
    if not (np.diff(t) > 0.0).all():
        at = int(np.argmin(np.diff(t) > 0.0)) + 1
        raise DataError(f"{path}: the times must rise, and {clock} = {t[at]:g} follows {t[at - 1]:g}")
    points = np.column_stack([s.values(table[s.column], t) for s in sources.values()])
    return RunInputs(t, "" if clock is None else "s", points, {n: given.get(n, n) for n in inputs})


def surface(
    file: SystemFile,
    out: Annotated[
        Path,
        typer.Option("--out", "-o", metavar="FILE", help="A picture (.png, .svg, .pdf) or the table (.csv, .fld)."),
    ],
    x: Annotated[str | None, typer.Option(metavar="INPUT", help="The first input unless given.")] = None,
    y: Annotated[str | None, typer.Option(metavar="INPUT", help="The next input unless given.")] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="INPUT=VALUE", help="Holds an input that is not drawn; the middle unless given."),
    ] = None,
    output: Annotated[str | None, typer.Option(help="What a picture shows; the first output unless given.")] = None,
    points: Annotated[int, typer.Option(metavar="N", help="Points along each input.")] = 101,
    kind: Annotated[str, typer.Option(help="Of a picture: map, 3d or both.")] = "both",
    leave_out_unknown: LeaveOut = False,
    as_json: Json = False,
) -> None:
    """Draw or tabulate the outputs over the universes of two inputs, or of the only one."""
    from leadscrew.report import fuzzy as pictures

    suffix = suffix_of(out, (*PICTURES, ".csv", ".fld"), "--out")
    system = system_of(file, leave_out_unknown)
    if output is not None:
        known(output, [o.name for o in system.outputs], "output")
    with busy(f"{system.name}, {points} points an input"):
        made = pictures.surface(system, x, y, numbers(at or [], "--at"), points)
        if suffix in PICTURES:
            save(pictures.surface_figure(made, output=output, kind=kind), out)
        else:
            save_table(*made.rows(), out)
    drawn = [v.name for v in (made.x, made.y) if v is not None]
    gaps = int((made.output(output)[1] != made.output(output)[1]).sum())
    size = made.values[..., 0].size
    held = "".join(f", {n} = {v:g}" for n, v in made.held.items())
    lost = [f"{gaps} of {size} points have no value"] if gaps else []
    report = Report(
        {**head("fuzzy surface"), "file": str(file), "system": system.name, "inputs": drawn, "held": made.held,
         "output": made.output(output)[0].name, "points": size, "without_value": gaps},
        parts=lost,
        files=[File("out", out, f"{made.output(output)[0].name} over {' and '.join(drawn)}{held}; {size} points")],
    )  # fmt: skip
    deliver(report, as_json=as_json)


def activity(
    file: SystemFile,
    run: Annotated[
        Path,
        typer.Argument(metavar="RUN", help="A recorded run: .csv, .parquet, or a folder of leadscrew simulate --out."),
    ],
    maps: Annotated[
        list[str] | None,
        typer.Option(
            "--map",
            metavar="INPUT=COLUMN",
            help="Where an input comes from; a column of its own name unless given. Also INPUT=SCALE*COLUMN, "
            "and change(COLUMN), the difference to the row before, or rate(COLUMN), that over time.",
        ),
    ] = None,
    time: Annotated[str | None, typer.Option(metavar="COLUMN", help="Seconds; the column 'time' if there is one.")] = (
        None
    ),
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FILE", help="A picture (.png, .svg, .pdf) or the strengths (.csv)."),
    ] = None,
    leave_out_unknown: LeaveOut = False,
    as_json: Json = False,
) -> None:
    """Which rules a recorded run used, for how long and how strongly, and which never fired."""
    from leadscrew.fuzzy.explanation import activity as strengths_of
    from leadscrew.fuzzy.explanation import usage

    if out is not None:
        suffix_of(out, (*PICTURES, ".csv"), "--out")
    system = system_of(file, leave_out_unknown)
    found = recorded_inputs(run, [v.name for v in system.inputs], maps or [], time)
    with busy(f"{system.name}, {len(found.time)} rows"):
        strengths = strengths_of(system, found.points)
        uses = usage(system, found.time, strengths)
        if out is not None:
            _write(system, found, strengths, out)
    silent = float((~(strengths > 0.0).any(axis=1)).mean())
    report = Report(
        {**head("fuzzy activity"), "file": str(file), "system": system.name, "run": str(run),
         "rows": len(found.time), "map": found.sources, "unit": found.unit or "rows", "no_rule_fires": silent,
         "rules": [vars(u) for u in uses]},
        parts=list(_uses(system, uses, found, silent)),
        files=[File("out", out, f"{len(found.time)} rows")],
    )  # fmt: skip
    deliver(report, as_json=as_json)


def _write(system: System, found: RunInputs, strengths: np.ndarray, out: Path) -> None:
    import numpy as np

    if out.suffix.casefold() == ".csv":
        names = ["time" if found.unit else "row", *(v.name for v in system.inputs)]
        names += [f"rule {i + 1}" for i in range(strengths.shape[1])]
        save_table(names, np.column_stack([found.time, found.points, strengths]), out)
        return
    from leadscrew.report.fuzzy import activity_figure

    save(activity_figure(system, found.time, found.points, unit=found.unit), out)


def _uses(system: System, uses: tuple[Use, ...], found: RunInputs, silent: float) -> Iterator[Part]:
    """The rules by how long they fired, then those that never did."""
    fired = sorted((u for u in uses if u.seconds > 0.0), key=lambda u: (-u.seconds, -u.mean))
    yield f"{system.name}: {len(fired)} of {len(uses)} rules fired in {len(found.time)} rows"
    yield f"from {', '.join(f'{k} = {v}' for k, v in found.sources.items())}"
    if silent:
        yield f"no rule fired in {number(100.0 * silent, 3)} % of the rows"
    if fired:
        of = found.unit or "rows"
        heads = ["rule", f"fired ({of})", "% of the run", "mean strength", "strongest", f"at ({of})", ""]
        rows = [[str(u.number), number(u.seconds), fixed(100.0 * u.part, 1), number(u.mean, 3), number(u.strongest, 3),
                 number(u.at), u.text] for u in fired]  # fmt: skip
        yield TextTable(heads, rows, [*[True] * 6, False])
    for words, enabled in (("never fired", True), ("switched off", False)):
        unused = [u for u in uses if not u.seconds and u.enabled == enabled]
        if unused:
            yield Lines([f"{words}: {len(unused)}", *(f"{u.number:>4}  {u.text}" for u in unused)])


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
    from leadscrew.logs import read_table

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
        table = read_table(log)
        data = {name: table.numbers(name) for name in (*asked, output, *([weights] if weights else []))}
        learned = learn_from(data, asked, output, **choices)
        notes = formats.write(learned.system, out) if out else ()
    report = Report(
        {**head("fuzzy learn"), "log": str(log), **learned.as_dict(), "notes": list(notes)},
        parts=[Lines(learned.report(most).splitlines()), *notes],
        files=[File("out", out, f"{len(learned.system.rules)} rules")],
    )
    deliver(report, as_json=as_json)


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


app = typer.Typer(help="Fuzzy systems in files: .fis, .fll, .fcl, IEEE 1855 .xml.", no_args_is_help=True)
app.command("show")(show)
app.command("convert")(convert)
app.command("eval")(eval_)
app.command("surface")(surface)
app.command("activity")(activity)
app.command("learn")(learn)
app.command("bench")(bench)
