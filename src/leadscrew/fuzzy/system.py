"""A fuzzy system as plain data: variables with their terms, rule blocks, rules. What computes with it stands
elsewhere and is only called from here (``system(...)``, ``system.many(...)``, ``system.explain(...)``).

The vocabulary is that of the field and of the files that are read and written (MATLAB ``.fis``, fuzzylite ``.fll``,
IEC 61131-7 ``.fcl``, IEEE 1855). What each name means as a formula stands where it is computed:
:mod:`leadscrew.fuzzy.shapes` (terms), :mod:`leadscrew.fuzzy.norms` (norms and hedges),
:mod:`leadscrew.fuzzy.defuzzifiers`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import NameUnknown, ValueRefused, entry_point

if TYPE_CHECKING:
    import numpy as np

    from leadscrew.fuzzy.evaluate import Compiled
    from leadscrew.fuzzy.explanation import Explanation

SHAPES: dict[str, tuple[str, ...]] = {
    "bell": ("center", "width", "slope"),
    "binary": ("start", "direction"),
    "concave": ("inflection", "end"),
    "constant": ("value",),
    "cosine": ("center", "width"),
    "discrete": (),
    "gaussian": ("mean", "deviation"),
    "gaussian_product": ("mean_a", "deviation_a", "mean_b", "deviation_b"),
    "linear": (),
    "pi_shape": ("bottom_left", "top_left", "top_right", "bottom_right"),
    "ramp": ("start", "end"),
    "rectangle": ("start", "end"),
    "s_shape": ("start", "end"),
    "sigmoid": ("inflection", "slope"),
    "sigmoid_difference": ("left", "rising", "falling", "right"),
    "sigmoid_product": ("left", "rising", "falling", "right"),
    "singleton": ("value",),
    "spike": ("center", "width"),
    "trapezoid": ("a", "b", "c", "d"),
    "triangle": ("a", "b", "c"),
    "z_shape": ("start", "end"),
}
"""Shapes of terms and the names of their parameters. ``discrete`` takes x and y in turn, x increasing; ``linear``
(Takagi-Sugeno, first order) takes one coefficient for each input and a constant last; ``constant`` is the consequent of
a zero-order Takagi-Sugeno rule, ``singleton`` a set with one member."""

T_NORMS = (
    "minimum", "algebraic_product", "bounded_difference", "drastic_product", "einstein_product", "hamacher_product",
    "nilpotent_minimum",
)  # fmt: skip
S_NORMS = (
    "maximum", "algebraic_sum", "bounded_sum", "drastic_sum", "einstein_sum", "hamacher_sum", "nilpotent_maximum",
    "normalized_sum", "unbounded_sum",
)  # fmt: skip
HEDGES = ("any", "extremely", "not", "seldom", "somewhat", "very")
ACTIVATIONS = ("general", "first", "last", "highest", "lowest", "proportional", "threshold")
INTEGRAL = ("centroid", "bisector", "smallest_of_maximum", "mean_of_maximum", "largest_of_maximum")
WEIGHTED = ("weighted_average", "weighted_sum", "height")
DEFUZZIFIERS = (*INTEGRAL, *WEIGHTED)
RULES_OF_SUM = ("exact", "midpoint", "trapezoid")
"""How an integral over the output's universe is taken: in closed form (piecewise-linear sets only), by midpoints of
``resolution`` cells (as fuzzylite does), or by the trapezoid rule on ``resolution + 1`` nodes (as Octave and
MATLAB do)."""


def _one_of(what: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise ValueRefused(f"{what} = {value!r}{nearest(value, list(known))}")


@dataclass(frozen=True)
class Term:
    """A fuzzy set of a variable, or the consequent of a Takagi-Sugeno rule."""

    name: str
    shape: str
    parameters: tuple[float, ...]
    height: float = 1.0

    def __post_init__(self) -> None:
        _one_of(f"term {self.name}: shape", self.shape, tuple(SHAPES))
        object.__setattr__(self, "parameters", tuple(float(x) for x in self.parameters))
        names = SHAPES[self.shape]
        if names and len(self.parameters) != len(names):
            raise ValueRefused(
                f"term {self.name}: a {self.shape} takes {len(names)} numbers ({', '.join(names)}), "
                f"not {len(self.parameters)}"
            )
        if any(math.isnan(x) for x in self.parameters):
            raise ValueRefused(f"term {self.name}: a parameter is not a number (NaN)")
        if self.shape == "discrete":
            xs = self.parameters[::2]
            if len(self.parameters) < 4 or len(self.parameters) % 2 or list(xs) != sorted(xs):
                raise ValueRefused(
                    f"term {self.name}: a discrete set takes x and y in turn, two pairs or more, x rising"
                )
        if not (math.isfinite(self.height) and self.height > 0.0):
            raise ValueRefused(f"term {self.name}: height = {self.height!r}: allowed are positive numbers")


@dataclass(frozen=True)
class Variable:
    """What an input and an output have in common: a universe and its terms."""

    name: str
    low: float
    high: float
    terms: tuple[Term, ...]
    unit: str = ""
    doc: str = ""
    enabled: bool = True
    lock_range: bool = False
    """An input is held inside its universe before it is used; an output before it is given."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "terms", tuple(self.terms))
        if not self.low < self.high:
            raise ValueRefused(
                f"variable {self.name}: universe [{self.low}, {self.high}]: the low end must be below the high"
            )
        seen: set[str] = set()
        for term in self.terms:
            if term.name in seen:
                raise ValueRefused(f"variable {self.name}: two terms are called {term.name!r}")
            seen.add(term.name)

    def term(self, name: str) -> Term:
        """A term by name.

        Raises:
            NameUnknown: there is none; names the nearest.
        """
        for term in self.terms:
            if term.name == name:
                return term
        raise NameUnknown(f"variable {self.name} has no term {name!r}{nearest(name, [t.name for t in self.terms])}")


@dataclass(frozen=True)
class Input(Variable):
    """An input of a system."""


@dataclass(frozen=True)
class Output(Variable):
    """An output of a system: how its rules are put together and become a number."""

    aggregation: str | None = "maximum"
    """An S-norm; ``None`` (weighted defuzzifiers only) keeps every activated term apart."""
    defuzzifier: str = "centroid"
    integration: str = "midpoint"
    """One of :data:`RULES_OF_SUM`, for the integral defuzzifiers."""
    resolution: int = 100
    default: float = math.nan
    """The value where no rule fires."""
    lock_previous: bool = False
    """Where no rule fires, the last value stays."""

    def __post_init__(self) -> None:
        super().__post_init__()
        where = f"output {self.name}"
        if self.aggregation is not None:
            _one_of(f"{where}: aggregation", self.aggregation, S_NORMS)
        _one_of(f"{where}: defuzzifier", self.defuzzifier, DEFUZZIFIERS)
        _one_of(f"{where}: integration", self.integration, RULES_OF_SUM)
        if not 1 <= self.resolution <= 100_000:
            raise ValueRefused(f"{where}: resolution = {self.resolution}: allowed are 1 to 100000")
        self._one_nan()

    def _one_nan(self) -> None:
        # There is one object that is not a number, so that equal outputs have equal hashes.
        if math.isnan(self.default):
            object.__setattr__(self, "default", math.nan)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._one_nan()

    def __eq__(self, other: object) -> bool:
        """Equal in every field; a default that is not a number equals another one."""
        if not isinstance(other, Output):
            return NotImplemented
        names = [f.name for f in fields(self)]
        return [getattr(self, name) for name in names] == [getattr(other, name) for name in names]


@dataclass(frozen=True)
class Is:
    """``variable is [hedges] term``; hedges in the order in which they are written, the last one applied first."""

    variable: str
    term: str
    hedges: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for hedge in self.hedges:
            _one_of(f"{self.variable} is {self.term}: hedge", hedge, HEDGES)


@dataclass(frozen=True)
class And:
    """Both; by the block's conjunction."""

    left: Antecedent
    right: Antecedent


@dataclass(frozen=True)
class Or:
    """Either; by the block's disjunction."""

    left: Antecedent
    right: Antecedent


Antecedent = Is | And | Or


@dataclass(frozen=True)
class Rule:
    """``if antecedent then consequents with weight``."""

    antecedent: Antecedent
    consequents: tuple[Is, ...]
    weight: float = 1.0
    enabled: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "consequents", tuple(self.consequents))
        if not self.consequents:
            raise ValueRefused("a rule without a consequent")
        if not 0.0 <= self.weight <= 1.0:
            raise ValueRefused(f"a rule's weight = {self.weight!r}: allowed is 0 to 1")

    def propositions(self) -> Iterator[Is]:
        """The propositions of the antecedent, from left to right."""
        todo: list[Antecedent] = [self.antecedent]
        while todo:
            node = todo.pop()
            if isinstance(node, Is):
                yield node
            else:
                todo += [node.right, node.left]


@dataclass(frozen=True)
class RuleBlock:
    """Rules that share their norms."""

    rules: tuple[Rule, ...]
    name: str = ""
    conjunction: str | None = "minimum"
    disjunction: str | None = "maximum"
    implication: str | None = "minimum"
    activation: str = "general"
    activation_parameters: tuple[str, ...] = ()
    """``first``, ``last``: number of rules, threshold; ``highest``, ``lowest``: number of rules; ``threshold``:
    comparison (``<``, ``<=``, ``==``, ``!=``, ``>=``, ``>``) and value."""
    enabled: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "rules", tuple(self.rules))
        for what, value, known in (
            ("conjunction", self.conjunction, T_NORMS),
            ("disjunction", self.disjunction, S_NORMS),
            ("implication", self.implication, T_NORMS),
        ):
            if value is not None:
                _one_of(f"rule block {self.name}: {what}", value, known)
        _one_of(f"rule block {self.name}: activation", self.activation, ACTIVATIONS)


@entry_point
@dataclass(frozen=True)
class System:
    """A whole fuzzy system; checked: every name in a rule exists."""

    name: str
    inputs: tuple[Input, ...]
    outputs: tuple[Output, ...]
    blocks: tuple[RuleBlock, ...]
    doc: str = ""
    notes: tuple[str, ...] = field(default=(), compare=False)
    """What a reader of a file has to say: what was left out, what was taken for what."""

    def __post_init__(self) -> None:
        for part in ("inputs", "outputs", "blocks"):
            object.__setattr__(self, part, tuple(getattr(self, part)))
        names = [v.name for v in (*self.inputs, *self.outputs)]
        for name in names:
            if names.count(name) > 1:
                raise ValueRefused(f"system {self.name}: two variables are called {name!r}")
        for block in self.blocks:
            for rule in block.rules:
                for there in rule.propositions():
                    self._check(there, antecedent=True)
                for there in rule.consequents:
                    self._check(there, antecedent=False)

    def _check(self, there: Is, antecedent: bool) -> None:
        known = {v.name: v for v in ((*self.inputs, *self.outputs) if antecedent else self.outputs)}
        if there.variable not in known:
            side = "variable" if antecedent else "output"
            raise NameUnknown(
                f"system {self.name}: a rule names the {side} {there.variable!r}{nearest(there.variable, list(known))}"
            )
        if not (there.hedges and there.hedges[-1] == "any" and not there.term):
            known[there.variable].term(there.term)

    def variable(self, name: str) -> Input | Output:
        """An input or output by name.

        Raises:
            NameUnknown: there is none; names the nearest.
        """
        known = {v.name: v for v in (*self.inputs, *self.outputs)}
        if name not in known:
            raise NameUnknown(f"system {self.name} has no variable {name!r}{nearest(name, list(known))}")
        found: Input | Output = known[name]  # type: ignore[assignment]
        return found

    @property
    def rules(self) -> tuple[Rule, ...]:
        """All rules of all blocks, in order."""
        return tuple(rule for block in self.blocks for rule in block.rules)

    # ---- doors to what computes with it
    def __getstate__(self) -> dict[str, Any]:
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @cached_property
    def _compiled(self) -> Compiled:
        from leadscrew import fuzzy

        return fuzzy.compiled(self)

    def __call__(self, **inputs: float) -> dict[str, float]:
        """All outputs by name at one point, inputs by name; see :mod:`leadscrew.fuzzy.evaluate`.

        Raises:
            ValueRefused: no value for an input, or a system that cannot be evaluated.
            NameUnknown: there is no such input.
        """
        return self._compiled(**inputs)

    def many(self, points: Any = None, *, threads: int = 1, **inputs: Any) -> np.ndarray:
        """Outputs at many points; see :meth:`leadscrew.fuzzy.evaluate.Compiled.many`."""
        return self._compiled.many(points, threads=threads, **inputs)

    def explain(self, inputs: Mapping[str, float] | None = None, **named: float) -> Explanation:
        """Which rules fire at a point, how strongly, and their share of each output; prints as words.

        Raises:
            ValueRefused: no value for an input.
            NameUnknown: there is no such input.
        """
        from leadscrew import fuzzy

        return fuzzy.explain(self, {**(inputs or {}), **named})
