"""``leadscrew fuzzy show`` and ``convert``: what is in a file, and the same in another format."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.fuzzy_files import (
    PICTURES,
    SCHEMA_VERSION,
    File,
    LeaveOut,
    save_figure,
    suffix_of,
    system_of,
)
from leadscrew.cli.output import Json, emit, print_table
from leadscrew.kernel.errors import ValueRefused

if TYPE_CHECKING:
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
