"""Writes fuzzylite's ``.fll`` files, as version 6 reads them."""

from __future__ import annotations

from dataclasses import replace

from leadscrew.escape import one_line
from leadscrew.fuzzy.formats.place import plain
from leadscrew.fuzzy.formats.said import Saying, mapped
from leadscrew.fuzzy.formats.vocabulary import class_name, class_text
from leadscrew.fuzzy.rules_text import rule_text
from leadscrew.fuzzy.system import INTEGRAL, Antecedent, Input, Is, Output, Rule, RuleBlock, System, Variable

__all__ = ["dumps", "rules_as_fuzzylite", "shapes_of_fuzzylite"]

NAME = r"[A-Za-z0-9_.]+"


def dumps(system: System, notes: list[str] | None = None) -> str:
    """A system as ``.fll`` text; ``notes`` collects what was left out without an effect on outputs.

    Raises:
        ValueRefused: the format cannot express the system; names what.
    """
    saying = Saying("fll")
    system = saying.named(rules_as_fuzzylite(saying, saying.without_disabled_rules(system)), NAME)
    saying.units_and_docs(system, docs=False)
    shapes_of_fuzzylite(saying, system)
    lines = [f"# {comment}" for comment in saying.integration(system, "midpoint", None)]
    lines.append(f"Engine: {_line(saying, system.name)}".rstrip())
    if system.doc:
        lines.append(f"  description: {_line(saying, system.doc)}")
    for input in system.inputs:
        lines += _input(saying, input)
    for output in system.outputs:
        lines += _output(saying, output)
    for block in system.blocks:
        lines += _rule_block(saying, block)
    if notes is not None:
        notes += saying.notes
    return "\n".join(lines) + "\n"


def rules_as_fuzzylite(saying: Saying, system: System) -> System:
    """The system with ``any`` as fuzzylite writes it: without a term, and without what ``any`` makes of no effect."""

    def proposition(there: Is) -> Is:
        if "any" not in there.hedges:
            return there
        kept = there.hedges[: there.hedges.index("any") + 1]
        if there.term or kept != there.hedges:
            saying.note(
                f"{there.variable} is {' '.join((*there.hedges, there.term))}: what follows 'any' is not written"
            )
        return replace(there, hedges=kept, term="")

    def rule(r: Rule) -> Rule:
        antecedent: Antecedent = mapped(r.antecedent, proposition)
        for there in r.consequents:
            if "any" in there.hedges:
                saying.refuse(f"a rule that concludes '{there.variable} is any'")
        return replace(r, antecedent=antecedent)

    return replace(system, blocks=tuple(replace(b, rules=tuple(rule(r) for r in b.rules)) for b in system.blocks))


def shapes_of_fuzzylite(saying: Saying, system: System) -> None:
    """Refuses what fuzzylite does not have: the defuzzifier height, singletons as sets, heights of consequents."""
    for output in system.outputs:
        if output.defuzzifier == "height":
            saying.refuse(f"output {output.name}: the defuzzifier height")
    for variable in (*system.inputs, *system.outputs):
        for term in variable.terms:
            if term.shape in ("constant", "linear") and term.height != 1.0:
                saying.refuse(f"{variable.name}, term {term.name}: a height of {term.height!r} of a {term.shape}")


def _line(saying: Saying, text: str) -> str:
    """A text as it can stand after a key: one line, without the sign of comments."""
    found = one_line(text.replace("#", " "))
    if found != text:
        saying.note(f"{text!r} is written as {found!r}")
    return found


def _common(saying: Saying, variable: Variable) -> list[str]:
    for term in variable.terms:
        if term.shape == "singleton":
            saying.refuse(f"{variable.name}, term {term.name}: a singleton")
    about = [f"  description: {_line(saying, variable.doc)}"] if variable.doc else []
    return [
        *about,
        f"  enabled: {str(variable.enabled).lower()}",
        f"  range: {plain(variable.low)} {plain(variable.high)}",
        f"  lock-range: {str(variable.lock_range).lower()}",
    ]


def _terms(variable: Variable) -> list[str]:
    return [f"  term: {term.name} {class_text(term)}" for term in variable.terms]


def _input(saying: Saying, variable: Input) -> list[str]:
    return [f"InputVariable: {variable.name}", *_common(saying, variable), *_terms(variable)]


def _output(saying: Saying, output: Output) -> list[str]:
    if output.defuzzifier in INTEGRAL:
        parameter = str(output.resolution)
    else:
        shapes = {term.shape for term in output.terms}
        parameter = "TakagiSugeno" if shapes <= {"constant", "linear"} else "Automatic"
    return [
        f"OutputVariable: {output.name}",
        *_common(saying, output),
        f"  aggregation: {_class(output.aggregation)}",
        f"  defuzzifier: {_class(output.defuzzifier)} {parameter}",
        f"  default: {plain(output.default)}",
        f"  lock-previous: {str(output.lock_previous).lower()}",
        *_terms(output),
    ]


def _class(name: str | None) -> str:
    return class_name(name) if name else "none"


def _rule_block(saying: Saying, block: RuleBlock) -> list[str]:
    return [
        f"RuleBlock: {_line(saying, block.name)}".rstrip(),
        f"  enabled: {str(block.enabled).lower()}",
        f"  conjunction: {_class(block.conjunction)}",
        f"  disjunction: {_class(block.disjunction)}",
        f"  implication: {_class(block.implication)}",
        f"  activation: {' '.join((_class(block.activation), *block.activation_parameters))}",
        *(f"  rule: {rule_text(rule, str)}" for rule in block.rules),
    ]
