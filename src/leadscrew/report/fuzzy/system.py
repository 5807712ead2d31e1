"""The report of ``leadscrew fuzzy show``: variables, terms, rules, norms, and how a system is evaluated."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from leadscrew.fuzzy.engine import engine
from leadscrew.fuzzy.rules_text import rule_text
from leadscrew.fuzzy.system import INTEGRAL, SHAPES, RuleBlock, System, Term, Variable
from leadscrew.fuzzy.tables import is_exact, is_integral
from leadscrew.report.fuzzy.membership import membership_figure
from leadscrew.report.report import Lines, Part, Report, TextTable, head
from leadscrew.util.errors import ValueRefused


def as_object(system: System) -> dict[str, Any]:
    """A system as plain data; infinite numbers are the texts ``inf`` and ``-inf``, as JSON has none."""

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


def report_of(file: Path, system: System) -> Report:
    """The report of ``leadscrew fuzzy show``."""
    counts = (len(system.inputs), "input"), (len(system.outputs), "output"), (len(system.rules), "rule")
    held = ", ".join(f"{n} {word}{'' if n == 1 else 's'}" for n, word in counts)
    heads = ("universe", "unit", "term", "shape", "parameters")
    tables = [
        TextTable.words((kind, *heads), [row for v in variables for row in _rows(v)])
        for kind, variables in (("input", system.inputs), ("output", system.outputs))
        if variables
    ]
    parts: list[Part] = [f"{system.name or file.stem} ({file}): {held}", *([system.doc] if system.doc else []), *tables]
    ways = evaluation(system)
    for output in system.outputs:
        parts.append(f"{output.name}: {_output(output)}")
        if output.name in ways:
            parts.append(f"{output.name} is evaluated: {ways[output.name]}")
    parts += [ways[""]] if "" in ways else []
    number = 0
    for block in system.blocks:
        lines = list(_rules(block, number))
        parts.append(Lines([_block(block), *lines]))
        number += len(lines)
    return Report(
        {**head("fuzzy show"), "file": str(file), **as_object(system)},
        parts=parts,
        notes=system.notes,
        figure=lambda: membership_figure(system),
    )


def _rows(variable: Variable) -> list[list[str]]:
    off = "" if variable.enabled else " (off)"
    locked = ", held inside" if variable.lock_range else ""
    head = [f"{variable.name}{off}", f"{variable.low:g} to {variable.high:g}{locked}", variable.unit]
    terms = variable.terms or (None,)
    return [[*(head if i == 0 else ["", "", ""]), *_term(term)] for i, term in enumerate(terms)]


def _term(term: Term | None) -> list[str]:
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


def _rules(block: RuleBlock, number: int) -> Iterator[str]:
    for n, rule in enumerate(block.rules, start=number + 1):
        yield f"{n:>4}  {rule_text(rule)}{'' if rule.enabled else '  (switched off)'}"
