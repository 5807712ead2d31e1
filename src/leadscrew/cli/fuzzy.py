"""``leadscrew fuzzy``: fuzzy systems in files, shown, converted, evaluated, drawn, learned from data, measured."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.fuzzy_files import (
    PICTURES,
    SCHEMA_VERSION,
    File,
    LeaveOut,
    columns_of,
    known,
    number_of,
    numbers,
    pairs,
    save_figure,
    save_table,
    suffix_of,
    system_of,
    table_of,
    text_table,
)
from leadscrew.cli.output import Json, busy, emit, print_table
from leadscrew.util.errors import DataError, LeadscrewError, NameUnknown, ValueRefused

if TYPE_CHECKING:
    import numpy as np

    from leadscrew.fuzzy.explanation import Use
    from leadscrew.fuzzy.system import RuleBlock, System, Term, Variable


# ---- show
def show(
    file: File,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Also draw the membership functions: .png, .svg or .pdf.")
    ] = None,
    leave_out_unknown: LeaveOut = False,
    as_json: Json = False,
) -> None:
    """Show what is in a file: variables, terms, rules, norms, and how the system is evaluated."""
    if plot is not None:
        suffix_of(plot, PICTURES, "--plot")
    system = system_of(file, leave_out_unknown)
    if plot is not None:
        from leadscrew.report.fuzzy import membership_figure

        save_figure(membership_figure(system), plot)
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), **as_object(system),
              "plot": None if plot is None else str(plot)})  # fmt: skip
        return
    print_system(file, system)
    if plot is not None:
        typer.echo(f"\n{plot}: the membership functions")


def as_object(system: System) -> dict[str, Any]:
    """A system as plain data; infinite numbers are the texts ``inf`` and ``-inf``, as JSON has none."""
    from dataclasses import asdict

    from leadscrew.fuzzy.rules_text import rule_text
    from leadscrew.fuzzy.system import SHAPES

    def variable(v: Variable) -> dict[str, Any]:
        found = asdict(v)
        for made, term in zip(found["terms"], v.terms, strict=True):
            made["parameters"] = [_finite(x) for x in term.parameters]
            made["names"] = list(SHAPES[term.shape])
        return {**found, "low": _finite(v.low), "high": _finite(v.high)}

    blocks, number = [], 0
    for block in system.blocks:
        rules = []
        for rule in block.rules:
            number += 1
            rules.append({"number": number, "text": rule_text(rule), "weight": rule.weight, "enabled": rule.enabled})
        blocks.append({**{k: v for k, v in vars(block).items() if k != "rules"}, "rules": rules})
    return {
        "name": system.name,
        "doc": system.doc,
        "notes": list(system.notes),
        "inputs": [variable(v) for v in system.inputs],
        "outputs": [variable(v) for v in system.outputs],
        "blocks": blocks,
        "evaluation": evaluation(system),
    }


def _finite(x: float) -> float | str:
    return repr(x) if x in (float("inf"), -float("inf")) else x


def evaluation(system: System) -> dict[str, str]:
    """How each output is evaluated, in words; an empty name where the system cannot be."""
    from leadscrew.fuzzy.engine import engine
    from leadscrew.fuzzy.tables import is_exact, is_integral

    try:
        made = engine(system)
    except ValueRefused as error:
        return {"": f"cannot be evaluated: {error}"}
    rules, found = len(made.circuit.firings), {}
    for output in system.outputs:
        if not output.enabled:
            words = "switched off: NaN"
        elif output.name in made.traits.tabled:
            words = "active rules: a table of the rules' values is interpolated, only the rules around a point count"
        elif is_exact(output):
            shape = "of a partition, " if output.name in made.traits.cut else ""
            words = f"exact: {rules} rules, then the centroid {shape}in closed form"
        elif is_integral(output):
            words = f"general: {rules} rules, then {output.defuzzifier.replace('_', ' ')} by {output.integration} on "
            words += f"{output.resolution} cells"
        else:
            words = f"general: {rules} rules, then {output.defuzzifier.replace('_', ' ')}"
        found[output.name] = words
    return found


def print_system(file: Path, system: System) -> None:
    """A system in words."""
    counts = (len(system.inputs), "input"), (len(system.outputs), "output"), (len(system.rules), "rule")
    said = ", ".join(f"{n} {word}{'' if n == 1 else 's'}" for n, word in counts)
    typer.echo(f"{system.name or file.stem} ({file}): {said}")
    if system.doc:
        typer.echo(system.doc)
    for note in system.notes:
        typer.echo(f"note: {note}")
    for kind, variables in (("input", system.inputs), ("output", system.outputs)):
        if variables:
            typer.echo()
            rows = [row for v in variables for row in _rows(v)]
            print_table([kind, "universe", "unit", "term", "shape", "parameters"], rows)
    ways = evaluation(system)
    typer.echo()
    for output in system.outputs:
        typer.echo(f"{output.name}: {_output(output)}")
        if output.name in ways:
            typer.echo(f"  evaluated: {ways[output.name]}")
    if "" in ways:
        typer.echo(ways[""])
    number = 0
    for block in system.blocks:
        typer.echo(f"\n{_block(block)}")
        number = _print_rules(block, number)


def _rows(variable: Variable) -> list[list[str]]:
    off = "" if variable.enabled else " (off)"
    locked = ", held inside" if variable.lock_range else ""
    head = [f"{variable.name}{off}", f"{variable.low:g} to {variable.high:g}{locked}", variable.unit]
    terms = variable.terms or (None,)
    return [[*(head if i == 0 else ["", "", ""]), *_term(term)] for i, term in enumerate(terms)]


def _term(term: Term | None) -> list[str]:
    from leadscrew.fuzzy.system import SHAPES

    if term is None:
        return ["no terms", "", ""]
    names = SHAPES[term.shape]
    if term.shape == "discrete":
        xy = zip(term.parameters[::2], term.parameters[1::2], strict=True)
        words = " ".join(f"({x:g}, {y:g})" for x, y in xy)
    else:
        named = zip(names, term.parameters, strict=True) if names else (("", x) for x in term.parameters)
        words = ", ".join(f"{n} {x:g}".strip() for n, x in named)
    return [term.name, term.shape, words if term.height == 1.0 else f"{words}, height {term.height:g}"]


def _output(output: Any) -> str:
    from leadscrew.fuzzy.system import INTEGRAL

    words = [output.defuzzifier.replace("_", " "), f"aggregation {output.aggregation or 'none'}"]
    if output.defuzzifier in INTEGRAL:
        words.append(output.integration if output.integration == "exact" else f"{output.integration} rule")
    otherwise = "the last value stays" if output.lock_previous else ""
    if output.default == output.default:
        otherwise += f"{', else ' if otherwise else ''}{output.default:g}"
    return f"{', '.join(words)}; where no rule fires {otherwise or 'NaN'}"


def _block(block: RuleBlock) -> str:
    norms = f"and {block.conjunction or '–'}, or {block.disjunction or '–'}, implication {block.implication or '–'}"
    how = " ".join((block.activation, *block.activation_parameters))
    off = "" if block.enabled else ", switched off"
    return f"{' '.join(('rules', block.name)).strip()}: {norms}, activation {how}{off}"


def _print_rules(block: RuleBlock, number: int) -> int:
    from leadscrew.fuzzy.rules_text import rule_text

    for rule in block.rules:
        number += 1
        typer.echo(f"{number:>4}  {rule_text(rule)}{'' if rule.enabled else '  (switched off)'}")
    return number


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
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "from": str(source), "to": str(target), "name": system.name,
              "rules": len(system.rules), "read": list(system.notes), "not_said": list(lost)})  # fmt: skip
        return
    typer.echo(f"{target}: {system.name or source.stem}, {len(system.rules)} rules")
    for note in system.notes:
        typer.echo(f"read: {note}")
    for note in lost:
        typer.echo(f"not said: {note}")


def eval_(
    file: File,
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
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "system": system.name, "engine": engine,
              "inputs": inputs, "outputs": outputs, "units": {o.name: o.unit for o in system.outputs},
              "explanation": None if why is None else why.as_dict()})  # fmt: skip
        return
    if why is not None:
        typer.echo(str(why))
        return
    for output in system.outputs:
        typer.echo(f"{output.name} = {outputs[output.name]!r} {output.unit}".rstrip())


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
    if as_json:
        found = {n: y[:, i] for i, n in enumerate(outputs)} if out is None else None
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "system": system.name, "engine": engine,
              "points": len(x), "out": None if out is None else str(out), "outputs": found})  # fmt: skip
    elif out is None:
        typer.echo(text_table([*names, *outputs], np.column_stack([x, y])), nl=False)
    else:
        typer.echo(f"{out}: {len(x)} points, {', '.join(outputs)}")


COLUMNS = ("name", "what", "value", "unit", "ratio", "remark")


def bench(
    file: File,
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
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "system": system.name, "points": points,
              "rows": rows})  # fmt: skip
        return
    print_table(COLUMNS, [[_cell(row.get(c)) for c in COLUMNS] for row in rows], right=("value", "ratio"))


def _cell(value: Any) -> str:
    from leadscrew.figures.formats import number

    return "" if value is None or value == "" else number(value)


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
    said: dict[str, str]
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
    file: File,
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
            save_figure(pictures.surface_figure(made, output=output, kind=kind), out)
        else:
            save_table(*made.rows(), out)
    drawn = [v.name for v in (made.x, made.y) if v is not None]
    gaps = int((made.output(output)[1] != made.output(output)[1]).sum())
    size = made.values[..., 0].size
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "system": system.name, "out": str(out),
              "inputs": drawn, "held": made.held, "output": made.output(output)[0].name, "points": size,
              "without_value": gaps})  # fmt: skip
        return
    held = "".join(f", {n} = {v:g}" for n, v in made.held.items())
    typer.echo(f"{out}: {made.output(output)[0].name} over {' and '.join(drawn)}{held}; {size} points")
    if gaps:
        typer.echo(f"{gaps} of {size} points have no value")


def activity(
    file: File,
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
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "system": system.name, "run": str(run),
              "rows": len(found.time), "map": found.said, "unit": found.unit or "rows", "no_rule_fires": silent,
              "rules": [vars(u) for u in uses], "out": None if out is None else str(out)})  # fmt: skip
        return
    print_uses(system, uses, found, silent)
    if out is not None:
        typer.echo(f"\n{out}: {len(found.time)} rows")


def _write(system: System, found: RunInputs, strengths: np.ndarray, out: Path) -> None:
    import numpy as np

    if out.suffix.casefold() == ".csv":
        names = ["time" if found.unit else "row", *(v.name for v in system.inputs)]
        names += [f"rule {i + 1}" for i in range(strengths.shape[1])]
        save_table(names, np.column_stack([found.time, found.points, strengths]), out)
        return
    from leadscrew.report.fuzzy import activity_figure

    save_figure(activity_figure(system, found.time, found.points, unit=found.unit), out)


def print_uses(system: System, uses: tuple[Use, ...], found: RunInputs, silent: float) -> None:
    """The rules by how long they fired, then those that never did."""
    unit = found.unit or "rows"
    fired = sorted((u for u in uses if u.seconds > 0.0), key=lambda u: (-u.seconds, -u.mean))
    typer.echo(f"{system.name}: {len(fired)} of {len(uses)} rules fired in {len(found.time)} rows")
    typer.echo(f"from {', '.join(f'{k} = {v}' for k, v in found.said.items())}")
    if silent:
        typer.echo(f"no rule fired in {100.0 * silent:.3g} % of the rows")
    if fired:
        typer.echo()
        columns = ["rule", f"fired / {unit}", "% of the run", "mean strength", "strongest", f"at / {unit}", ""]
        rows = [[str(u.number), f"{u.seconds:.4g}", f"{100.0 * u.part:.1f}", f"{u.mean:.3g}", f"{u.strongest:.3g}",
                 f"{u.at:.4g}", u.text] for u in fired]  # fmt: skip
        print_table(columns, rows, right=columns[:-1])
    for words, which in (("never fired", True), ("switched off", False)):
        never: list[Any] = [u for u in uses if not u.seconds and u.enabled == which]
        if never:
            typer.echo(f"\n{words}: {len(never)}")
            for use in never:
                typer.echo(f"{use.number:>4}  {use.text}")


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


app = typer.Typer(help="Fuzzy systems in files: .fis, .fll, .fcl, IEEE 1855 .xml.", no_args_is_help=True)
app.command("show")(show)
app.command("convert")(convert)
app.command("eval")(eval_)
app.command("surface")(surface)
app.command("activity")(activity)
app.command("learn")(learn)
app.command("bench")(bench)
