"""Writes MATLAB ``.fis`` files: one set of methods for the whole system, rules by number."""

from __future__ import annotations

import math
from dataclasses import replace

from leadscrew.fuzzy.formats.fis_read import HEDGES
from leadscrew.fuzzy.formats.place import plain
from leadscrew.fuzzy.formats.said import Saying, uses
from leadscrew.fuzzy.formats.vocabulary import (
    FIS_DEFUZZIFIERS,
    FIS_S_NORMS,
    FIS_SHAPES,
    FIS_T_NORMS,
    FUZZYLITE_ONLY,
    first_name,
)
from leadscrew.fuzzy.system import WEIGHTED, And, Antecedent, Is, Or, Output, Rule, RuleBlock, System, Term, Variable

__all__ = ["dumps"]


def dumps(system: System, notes: list[str] | None = None) -> str:
    """A system as ``.fis`` text; ``notes`` collects what was left out without an effect on outputs.

    Raises:
        ValueRefused: the format cannot express the system; names what.
    """
    saying = Saying("fis")
    system = saying.without_disabled_rules(system)
    saying.units_and_docs(system, docs=True)
    for what, name in [("the system's", system.name), *_names(system)]:
        if any(c in name for c in "'\r\n") or not name.isprintable() or (what != "the system's" and not name):
            saying.refuse(f"{what} name {name!r}: it is empty or holds a quote or a control character")
    block = _one_block(saying, system)
    output = _one_kind_of_output(saying, system)
    sugeno = output.defuzzifier in WEIGHTED
    methods = {
        "AndMethod": _method(saying, "conjunction", block.conjunction, FIS_T_NORMS, "min"),
        "OrMethod": _method(saying, "disjunction", block.disjunction, FIS_S_NORMS, "max"),
        "ImpMethod": "prod" if sugeno else _method(saying, "implication", block.implication, FIS_T_NORMS, None),
        "AggMethod": "sum" if sugeno else _method(saying, "aggregation", output.aggregation, FIS_S_NORMS, None),
        "DefuzzMethod": _method(saying, "defuzzifier", output.defuzzifier, FIS_DEFUZZIFIERS, None),
    }
    lines = [f"% {comment}" for comment in saying.integration(system, "trapezoid", 100)]
    lines += ["[System]", f"Name='{system.name}'", f"Type='{'sugeno' if sugeno else 'mamdani'}'", "Version=2.0"]
    lines += [f"NumInputs={len(system.inputs)}", f"NumOutputs={len(system.outputs)}", f"NumRules={len(block.rules)}"]
    lines += [f"{key}='{name}'" for key, name in methods.items()]
    for kind, variables in (("Input", system.inputs), ("Output", system.outputs)):
        for index, variable in enumerate(variables, start=1):
            lines += ["", f"[{kind}{index}]", *_variable(saying, variable)]
    lines += ["", "[Rules]", *(_rule(saying, rule, system) for rule in block.rules)]
    if notes is not None:
        notes += saying.notes
    return "\n".join(lines) + "\n"


def _names(system: System) -> list[tuple[str, str]]:
    variables = (*system.inputs, *system.outputs)
    return [("a variable's", v.name) for v in variables] + [("a term's", t.name) for v in variables for t in v.terms]


def _one_block(saying: Saying, system: System) -> RuleBlock:
    """The rules of all blocks, which must not differ in their methods."""
    blocks = [block for block in system.blocks if block.enabled]
    if len(blocks) < len(system.blocks):
        saying.note("a rule block is switched off: not written")
    for block in blocks:
        if block.activation != "general":
            saying.refuse(f"rule block {block.name!r}: activation {block.activation}")
    first = blocks[0] if blocks else RuleBlock(())
    for what in ("conjunction", "disjunction", "implication"):
        if len({getattr(block, what) for block in blocks if block.rules}) > 1:
            saying.refuse(f"rule blocks that differ in their {what}")
    if len(blocks) > 1:
        saying.note("the rule blocks become one")
        first = next((block for block in blocks if block.rules), first)
    elif first.name:
        saying.note(f"the name of rule block {first.name!r} is not written")
    merged = replace(first, rules=tuple(rule for block in blocks for rule in block.rules))
    for what, kind in (("conjunction", And), ("disjunction", Or)):
        if getattr(merged, what) is None and uses(merged, kind):
            saying.refuse(f"rules that need a {what} in a block that has none")
    return merged


def _one_kind_of_output(saying: Saying, system: System) -> Output:
    """An output that stands for all, which must not differ in how they are aggregated and defuzzified."""
    if not system.outputs:
        saying.refuse("a system without outputs")
    for what in ("aggregation", "defuzzifier"):
        if len({getattr(output, what) for output in system.outputs}) > 1:
            saying.refuse(f"outputs that differ in their {what}")
    for output in system.outputs:
        if not math.isnan(output.default):
            saying.refuse(f"output {output.name}: a default of {output.default!r} where no rule fires")
        if output.lock_previous:
            saying.refuse(f"output {output.name}: that the last value stays where no rule fires")
        if output.defuzzifier in WEIGHTED and output.aggregation is not None:
            saying.refuse(f"output {output.name}: aggregation {output.aggregation} with {output.defuzzifier}")
    return system.outputs[0]


def _method(saying: Saying, what: str, value: str | None, known: dict[str, str], default: str | None) -> str:
    if value is None and default is not None:
        return default
    name = first_name(known, value or "")
    if name is None:
        saying.refuse(f"the {what} {value or 'none'}")
    if "_" in name:
        saying.note(f"{what} {name}: MATLAB reads it only with a function of that name")
    return name


def _variable(saying: Saying, variable: Variable) -> list[str]:
    for what in ("enabled", "lock_range"):
        if getattr(variable, what) != (what == "enabled"):
            saying.refuse(f"{variable.name}: {what} = {getattr(variable, what)}")
    lines = [f"Name='{variable.name}'", f"Range=[{plain(variable.low)} {plain(variable.high)}]"]
    lines.append(f"NumMFs={len(variable.terms)}")
    for index, term in enumerate(variable.terms, start=1):
        lines.append(f"MF{index}='{term.name}':{_function(saying, variable, term)}")
    return lines


def _function(saying: Saying, variable: Variable, term: Term) -> str:
    where = f"{variable.name}, term {term.name}"
    if term.height != 1.0 and term.shape not in ("constant", "linear"):
        saying.refuse(f"{where}: a height of {term.height!r}")
    kind, numbers = _kind(saying, where, term)
    if kind in FUZZYLITE_ONLY:
        saying.note(f"{where}: only fuzzylite reads {kind}")
    if kind in ("linsmf", "linzmf"):
        saying.note(f"{where}: {kind} is read by MATLAB, not by fuzzylite 6 and Octave")
    return f"'{kind}',[{' '.join(map(plain, numbers))}]"


def _kind(saying: Saying, where: str, term: Term) -> tuple[str, tuple[float, ...]]:
    if term.shape == "ramp":
        start, end = term.parameters
        return ("linsmf", (start, end)) if start <= end else ("linzmf", (end, start))
    for kind, (shape, order) in FIS_SHAPES.items():
        if shape == term.shape:
            places = order or tuple(range(len(term.parameters)))
            numbers = dict(zip(places, term.parameters, strict=True))
            return kind, tuple(numbers[k] for k in sorted(numbers))
    saying.refuse(f"{where}: a {term.shape}")


def _rule(saying: Saying, rule: Rule, system: System) -> str:
    clauses, kind = _clauses(saying, rule.antecedent)
    antecedent = _indices(saying, clauses, system.inputs, "input")
    consequents = _indices(saying, list(rule.consequents), system.outputs, "output")
    return f"{antecedent}, {consequents} ({plain(rule.weight) if rule.weight != 1.0 else 1}) : {kind}"


def _clauses(saying: Saying, node: Antecedent) -> tuple[list[Is], int]:
    """The propositions of a rule that has only ``and`` or only ``or``, and the number of its connective."""
    found: list[Is] = []
    kinds: set[type] = set()
    todo: list[Antecedent] = [node]
    while todo:
        node = todo.pop()
        if isinstance(node, Is):
            found.append(node)
        else:
            kinds.add(type(node))
            todo += [node.right, node.left]
    if len(kinds) > 1:
        saying.refuse("a rule with both 'and' and 'or'")
    return found, 2 if Or in kinds else 1


def _indices(saying: Saying, clauses: list[Is], variables: tuple[Variable, ...], what: str) -> str:
    numbers: dict[str, str] = {}
    known = {variable.name: variable for variable in variables}
    for there in clauses:
        if there.variable not in known:
            saying.refuse(f"a rule that asks for {there.variable}, which is no {what}")
        if there.variable in numbers:
            saying.refuse(f"a rule that names {there.variable} twice")
        numbers[there.variable] = _index(saying, there, known[there.variable])
    return " ".join(numbers.get(variable.name, "0") for variable in variables)


def _index(saying: Saying, there: Is, variable: Variable) -> str:
    sign = there.hedges[:1] == ("not",)
    hedges = there.hedges[sign:]
    hundredths = next((number for number, known in HEDGES.items() if known == hedges), None)
    if hundredths is None or not there.term or hundredths == 99:
        saying.refuse(f"'{' '.join((there.variable, 'is', *there.hedges, there.term)).rstrip()}'")
    index = 1 + [term.name for term in variable.terms].index(there.term)
    return f"{'-' if sign else ''}{index}{f'.{hundredths:02d}' if hundredths else ''}"
