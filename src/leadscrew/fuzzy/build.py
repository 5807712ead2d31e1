"""Fuzzy systems built in Python: rows of sets, and whole systems of the usual kinds with their norms.

    mamdani         and: minimum,  implication: minimum,  aggregation: maximum, exact centroid
    larsen          and: product,  implication: product,  aggregation: maximum, exact centroid
    takagi_sugeno   and: product,  the mean of the rules' constants or linear forms, weighted by their degrees
    tsukamoto       and: product,  the mean of where the rules' monotonic sets have their degrees, likewise

Source: E. H. Mamdani, S. Assilian (1975); P. M. Larsen (1980); T. Takagi, M. Sugeno (1985); Y. Tsukamoto (1979).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from leadscrew.fuzzy import rules_text
from leadscrew.fuzzy.rules_text import Names
from leadscrew.fuzzy.shapes import STRAIGHT
from leadscrew.fuzzy.system import Input, Output, Rule, RuleBlock, System, Term
from leadscrew.util.errors import ValueRefused, entry_point


@entry_point
def triangles(
    labels: str | Sequence[str], low: float, high: float, centres: Sequence[float] | None = None, shoulders: bool = True
) -> tuple[Term, ...]:
    """A triangular partition of unity: one set a label, peaks evenly from ``low`` to ``high`` or at ``centres``.

    ``shoulders``: the outer sets stay 1 beyond the ends; otherwise they fall to 0 as far out as their inner feet lie
    inside.

    Raises:
        ValueRefused: fewer than two labels, or centres that do not rise or are not as many.
    """
    names = labels.split() if isinstance(labels, str) else list(labels)
    if len(names) < 2:
        raise ValueRefused(f"labels = {names}: a partition needs two sets or more")
    n = len(names) - 1
    peaks = [low + (high - low) * i / n for i in range(n + 1)] if centres is None else [float(c) for c in centres]
    if len(peaks) != len(names) or any(not a < b for a, b in itertools.pairwise(peaks)):
        raise ValueRefused(f"centres = {peaks}: allowed are {len(names)} rising numbers, one a label")
    left = -math.inf if shoulders else 2.0 * peaks[0] - peaks[1]
    right = math.inf if shoulders else 2.0 * peaks[-1] - peaks[-2]
    feet = [left, *peaks, right]
    return tuple(Term(name, "triangle", tuple(feet[i : i + 3])) for i, name in enumerate(names))


@entry_point
def constants(values: Mapping[str, float]) -> tuple[Term, ...]:
    """Constants by name: the consequents of a zero-order Takagi-Sugeno system."""
    return tuple(Term(name, "constant", (float(v),)) for name, v in values.items())


@entry_point
def linear(values: Mapping[str, Sequence[float]]) -> tuple[Term, ...]:
    """Linear forms by name, a coefficient for each input and the constant last: first-order Takagi-Sugeno."""
    return tuple(Term(name, "linear", tuple(v)) for name, v in values.items())


def rules(given: str | Iterable[str | Rule], inputs: Sequence[Input], outputs: Sequence[Output]) -> tuple[Rule, ...]:
    """Rules of a text with one rule a line, of a table (two inputs, one output: the first line holds the terms of the
    second input, each further line a term of the first one and its cells, ``-`` for no rule), or of a list of either
    form.

    Raises:
        DataError: it is neither, or names what does not exist; says ``rules:line:column`` and what was expected.
    """
    names = Names.of(inputs, outputs)
    if isinstance(given, str):
        lines = given.splitlines()
        first = next((line.split()[0].casefold() for line in lines if line.strip()), "")
        if first != "if" and len(inputs) == 2 and len(outputs) == 1:
            return rules_text.table(given, inputs[0].name, inputs[1].name, outputs[0].name, names, where="rules")
        return tuple(
            rules_text.parse(line, names, where="rules", line=number)
            for number, line in enumerate(lines, start=1)
            if line.strip() and not line.lstrip().startswith("#")
        )
    return tuple(r if isinstance(r, Rule) else rules_text.parse(r, names, where="rules") for r in given)


def _system(
    name: str,
    inputs: Sequence[Input] | Input,
    outputs: Sequence[Output] | Output,
    given: Any,
    output: Mapping[str, Any],
    block: Mapping[str, Any],
    doc: str,
) -> System:
    ins = (inputs,) if isinstance(inputs, Input) else tuple(inputs)
    outs = (outputs,) if isinstance(outputs, Output) else tuple(outputs)
    outs = tuple(replace(o, **output) for o in outs)
    return System(name, ins, outs, (RuleBlock(rules(given, ins, outs), **block),), doc=doc)


@entry_point
def mamdani(
    name: str,
    inputs: Sequence[Input] | Input,
    outputs: Sequence[Output] | Output,
    rules: str | Iterable[str | Rule],
    *,
    defuzzifier: str = "centroid",
    integration: str | None = None,
    doc: str = "",
) -> System:
    """A Mamdani system: minimum, minimum, maximum. The centroid is exact where all output sets have straight sides and
    nothing else is asked for by ``integration`` (``midpoint`` or ``trapezoid``, with the outputs' own resolution).

    Raises:
        DataError: rules that cannot be read.
        ValueRefused, NameUnknown: see :class:`System`.
    """
    return _cut_or_scaled("minimum", name, inputs, outputs, rules, defuzzifier, integration, doc)


@entry_point
def larsen(
    name: str,
    inputs: Sequence[Input] | Input,
    outputs: Sequence[Output] | Output,
    rules: str | Iterable[str | Rule],
    *,
    defuzzifier: str = "centroid",
    integration: str | None = None,
    doc: str = "",
) -> System:
    """A Larsen system: product, product, maximum; otherwise as :func:`mamdani`."""
    return _cut_or_scaled("algebraic_product", name, inputs, outputs, rules, defuzzifier, integration, doc)


def _cut_or_scaled(
    norm: str, name: str, inputs: Any, outputs: Any, given: Any, defuzzifier: str, integration: str | None, doc: str
) -> System:
    outs = (outputs,) if isinstance(outputs, Output) else tuple(outputs)
    straight = all(t.shape in (*STRAIGHT, "discrete") for o in outs for t in o.terms)
    chosen = integration or ("exact" if straight and defuzzifier == "centroid" else "midpoint")
    output = {"aggregation": "maximum", "defuzzifier": defuzzifier, "integration": chosen}
    block = {"conjunction": norm, "disjunction": "maximum", "implication": norm}
    return _system(name, inputs, outs, given, output, block, doc)


@entry_point
def takagi_sugeno(
    name: str,
    inputs: Sequence[Input] | Input,
    outputs: Sequence[Output] | Output,
    rules: str | Iterable[str | Rule],
    *,
    defuzzifier: str = "weighted_average",
    conjunction: str = "algebraic_product",
    doc: str = "",
) -> System:
    """A Takagi-Sugeno system: outputs have :func:`constants` (zero order) or :func:`linear` forms (first order).

    Raises:
        DataError: rules that cannot be read.
        ValueRefused, NameUnknown: see :class:`System`.
    """
    output = {"aggregation": None, "defuzzifier": defuzzifier}
    either = "algebraic_sum" if conjunction == "algebraic_product" else "maximum"
    block = {"conjunction": conjunction, "disjunction": either, "implication": None}
    return _system(name, inputs, outputs, rules, output, block, doc)


@entry_point
def tsukamoto(
    name: str,
    inputs: Sequence[Input] | Input,
    outputs: Sequence[Output] | Output,
    rules: str | Iterable[str | Rule],
    *,
    conjunction: str = "algebraic_product",
    doc: str = "",
) -> System:
    """A Tsukamoto system: outputs have monotonic sets (ramp, sigmoid, s, z, concave).

    Raises:
        ValueRefused: a set that is not monotonic.
        DataError: rules that cannot be read.
    """
    outs = (outputs,) if isinstance(outputs, Output) else tuple(outputs)
    monotonic = ("ramp", "sigmoid", "s_shape", "z_shape", "concave")
    for o in outs:
        for t in o.terms:
            if t.shape not in monotonic:
                raise ValueRefused(
                    f"output {o.name}: {t.name} is a {t.shape}; Tsukamoto's sets are one of {', '.join(monotonic)}"
                )
    return takagi_sugeno(name, inputs, outs, rules, conjunction=conjunction, doc=doc)
