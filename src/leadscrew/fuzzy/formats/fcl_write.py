"""Writes IEC 61131-7 fuzzy control language, ``.fcl``, as fuzzylite 6 reads it."""

from __future__ import annotations

import re

from leadscrew.fuzzy.formats.fcl_terms import term_text
from leadscrew.fuzzy.formats.fcl_text import KEYWORDS
from leadscrew.fuzzy.formats.fll_write import rules_as_fuzzylite, shapes_of_fuzzylite
from leadscrew.fuzzy.formats.place import plain
from leadscrew.fuzzy.formats.said import Saying
from leadscrew.fuzzy.formats.vocabulary import FCL_METHODS, FCL_S_NORMS, FCL_T_NORMS, first_name
from leadscrew.fuzzy.rules_text import rule_text
from leadscrew.fuzzy.system import WEIGHTED, RuleBlock, System, Variable

__all__ = ["dumps"]

_NAME = rf"(?!(?i:{'|'.join(KEYWORDS)}|inf|nan)\Z)[A-Za-z_][A-Za-z0-9_]*"
_TITLE = r"[A-Za-z_][A-Za-z0-9_]*(?: [A-Za-z0-9_]+)*"


def dumps(system: System, notes: list[str] | None = None) -> str:
    """A system as ``.fcl`` text; ``notes`` collects what was left out without an effect on outputs.

    Raises:
        ValueRefused: the format cannot express the system; names what.
    """
    saying = Saying("fcl")
    system = saying.named(rules_as_fuzzylite(saying, saying.without_disabled_rules(system)), _NAME)
    saying.units_and_docs(system, docs=True)
    shapes_of_fuzzylite(saying, system)
    lines = [f"// {comment}" for comment in saying.integration(system, "midpoint", 100)]
    lines += [f"FUNCTION_BLOCK {_title(saying, system.name)}".rstrip(), ""]
    for section, variables in (("VAR_INPUT", system.inputs), ("VAR_OUTPUT", system.outputs)):
        lines += [section, *(f"  {variable.name}: REAL;" for variable in variables), "END_VAR", ""]
    for input in system.inputs:
        if input.lock_range:
            saying.refuse(f"input {input.name}: that it is held inside its universe")
        lines += [f"FUZZIFY {input.name}", *_common(saying, input, "constant"), "END_FUZZIFY", ""]
    for output in system.outputs:
        no = "singleton" if output.defuzzifier in WEIGHTED else "constant"
        lines += [
            f"DEFUZZIFY {output.name}",
            *_common(saying, output, no),
            f"  METHOD : {first_name(FCL_METHODS, output.defuzzifier)};",
        ]
        if output.aggregation:
            lines.append(f"  ACCU : {first_name(FCL_S_NORMS, output.aggregation)};")
        lines.append(f"  DEFAULT := {plain(output.default)}{' | NC' if output.lock_previous else ''};")
        if output.lock_range:
            lines.append(f"  LOCK : RANGE{' | PREVIOUS' if output.lock_previous else ''};")
        lines += ["END_DEFUZZIFY", ""]
    for block in system.blocks:
        lines += [*_rule_block(saying, block), ""]
    lines.append("END_FUNCTION_BLOCK")
    if notes is not None:
        notes += saying.notes
    return "\n".join(lines) + "\n"


def _title(saying: Saying, name: str, between: str = " ") -> str:
    """A name of a block of which every word can stand in the file (of a rule block, one word: fuzzylite takes one)."""
    words = [re.sub(r"\W", "_", word, flags=re.ASCII) for word in name.split()]
    words = [f"{word}_" if word.casefold() in (*KEYWORDS, "and", "or") else word for word in words]
    title = between.join(words)
    title = title if re.fullmatch(_TITLE, title) or not title else f"_{title}"
    if title != name:
        saying.note(f"{name!r} is called {title!r} in the file")
    return title


def _common(saying: Saying, variable: Variable, no: str) -> list[str]:
    """Range and terms; a number is a constant where the defuzzifier is weighted and else a singleton: ``no`` is the
    shape that it cannot be here.
    """
    for term in variable.terms:
        if term.shape == no or (term.shape == "singleton" and term.height != 1.0):
            saying.refuse(f"{variable.name}, term {term.name}: a {term.shape}")
    return [
        *([] if variable.enabled else ["  ENABLED : FALSE;"]),
        f"  RANGE := ({plain(variable.low)} .. {plain(variable.high)});",
        *(f"  TERM {term.name} := {term_text(term)};" for term in variable.terms),
    ]


def _rule_block(saying: Saying, block: RuleBlock) -> list[str]:
    if block.activation != "general":
        saying.refuse(f"rule block {block.name!r}: activation {block.activation}")
    lines = [f"RULEBLOCK {_title(saying, block.name, '_')}".rstrip()]
    if not block.enabled:
        lines.append("  ENABLED : FALSE;")
    for key, norm, known in (
        ("AND", block.conjunction, FCL_T_NORMS),
        ("OR", block.disjunction, FCL_S_NORMS),
        ("ACT", block.implication, FCL_T_NORMS),
    ):
        if norm:
            lines.append(f"  {key} : {first_name(known, norm)};")
    lines += [f"  RULE {k} : {rule_text(rule, str)};" for k, rule in enumerate(block.rules, start=1)]
    return [*lines, "END_RULEBLOCK"]
