"""The step of a fuzzy system, made once: its source, its functions, its prepared numbers."""

from __future__ import annotations

import hashlib
import linecache
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from leadscrew.fuzzy.circuit import Circuit, circuit
from leadscrew.fuzzy.exact_centroid import prepare_lines
from leadscrew.fuzzy.inference import axis_numbers, is_pointed, is_table, table
from leadscrew.fuzzy.system import System
from leadscrew.fuzzy.tables import (
    FIRST,
    PEAK,
    Tables,
    cuts,
    is_exact,
    is_integral,
    partition_of,
    places,
    prepare_points,
    prepare_sets,
    prepare_terms,
    tables,
    tuned_terms,
)
from leadscrew.fuzzy.writer import Writer, variable_names
from leadscrew.kernel.guards import unguarded
from leadscrew.util.errors import ValueRefused
from leadscrew.util.escape import one_line

HOME = "leadscrew.fuzzy.generated"
"""The module that written functions say that they are of."""


@dataclass(frozen=True)
class Traits:
    """What of a system's numbers its step is written for."""

    weighted: bool
    """A rule has a weight other than 1."""
    tall: frozenset[tuple[str, str]]
    """Terms of a height other than 1."""
    cut: frozenset[str]
    """Inputs whose terms are a triangular partition of unity, and exact outputs whose terms just fill the universe."""

    tabled: frozenset[str]
    """Outputs that are the interpolation of a table."""


def traits(made: Circuit, numbers: Tables) -> Traits:
    """What the step of a system with these numbers may count on."""
    terms = tuned_terms(made, numbers)
    tall = frozenset(key for key, term in terms.items() if term.height != 1.0)
    cut = frozenset(v.name for v in made.system.inputs if cuts([terms[v.name, t.name] for t in v.terms]) is not None)
    full = frozenset(o.name for o in made.system.outputs if is_exact(o) and partition_of(made, numbers, o) is not None)
    weighted = bool((numbers.weights[[f.number for f in made.firings]] != 1.0).any())
    active = not weighted and not tall and cut >= {v.name for v in made.system.inputs}
    active = active and all(
        is_pointed(sides)
        for v in made.system.inputs
        if (sides := cuts([terms[v.name, t.name] for t in v.terms])) is not None
    )
    tabled = frozenset(o.name for o in made.system.outputs if active and is_table(made, o))
    return Traits(weighted, tall, cut | full, tabled)


def execute(text: str, title: str, space: dict[str, Any]) -> dict[str, Any]:
    """Runs source that was written here, so that it can be read back: by the compiler, by pdb, in tracebacks."""
    name = f"<fuzzy {one_line(title)} {hashlib.sha256(text.encode()).hexdigest()[:12]}>"
    linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)
    space["__name__"] = HOME
    before = set(space)
    exec(compile(text, name, "exec"), space)
    for made in set(space) - before - {"__builtins__"}:
        unguarded(space[made])
    return space


@dataclass
class Engine:
    """A system made ready: plain functions in the step subset and what they need."""

    circuit: Circuit
    traits: Traits
    plan_type: Any
    space: dict[str, Any]
    text: str
    writer: Writer
    numbers: Tables
    plan: Any = field(init=False)

    def __post_init__(self) -> None:
        self.plan = self.prepared(self.numbers)

    @property
    def system(self) -> System:
        """The system."""
        return self.circuit.system

    @property
    def infer(self) -> Callable[..., Any]:
        """``infer(plan, inputs..., last outputs where they are locked)``: one output, or a tuple of them."""
        found: Callable[..., Any] = self.space["infer"]
        return found

    @property
    def locked(self) -> list[str]:
        """Outputs that keep their last value where no rule fires."""
        return [o.name for o in self.system.outputs if o.enabled and o.lock_previous]

    def prepared(self, numbers: Tables) -> Any:
        """The plan for some numbers.

        Raises:
            ValueRefused: numbers of another structure than the step was written for.
        """
        if traits(self.circuit, numbers) != self.traits:
            raise ValueRefused(
                f"system {self.system.name}: the new numbers change what its step is made of (a weight or height that "
                "was 1, or a partition that was none); make a new block of the changed system"
            )
        return self.plan_type(**plan_parts(self.circuit, self.traits, numbers))


def plan_parts(made: Circuit, have: Traits, numbers: Tables) -> dict[str, np.ndarray]:
    """The arrays of a plan by name."""
    names = variable_names(made.system)
    parts = {
        "terms": prepare_terms(made, numbers),
        "points": prepare_points(made, numbers),
        "linear": np.array(numbers.linear, dtype=float),
        "weights": np.array(numbers.weights, dtype=float),
    }
    terms, where = tuned_terms(made, numbers), places(made)
    for at, variable in enumerate(made.system.inputs):
        if variable.name in have.cut:
            sides = cuts([terms[variable.name, t.name] for t in variable.terms])
            assert sides is not None
            parts[f"cuts_{at}"] = sides
            if have.tabled:
                parts[f"centres_{at}"], parts[f"over_{at}"], parts[f"feet_{at}"] = axis_numbers(sides)
    for output in made.system.outputs:
        name = names[output.name]
        if output.name in have.tabled:
            column = PEAK if output.defuzzifier == "height" else FIRST
            values = {t.name: parts["terms"][where[output.name, t.name].row, column] for t in output.terms}
            parts[f"table_{name}"] = table(made, output, values)
        if is_integral(output) and output.terms:
            parts[f"nodes_{name}"], parts[f"sets_{name}"] = prepare_sets(made, numbers, output)
        elif is_exact(output) and output.name in have.cut:
            found = partition_of(made, numbers, output)
            assert found is not None
            parts[f"sets_{name}"], parts[f"between_{name}"] = found
        elif is_exact(output):
            own = [terms[output.name, t.name] for t in output.terms]
            parts[f"breaks_{name}"], parts[f"left_{name}"], parts[f"right_{name}"] = prepare_lines(output, own)
    return parts


def engine(system: System) -> Engine:
    """The step of a system.

    Raises:
        ValueRefused: something that cannot be evaluated; says what.
    """
    made = circuit(system)
    numbers = tables(made)
    have = traits(made, numbers)
    writer = Writer(made, have.weighted, have.tall, have.cut, have.tabled)
    parts = [writer.degrees(), *(writer.value(o) for o in writer.live), writer.infer(), writer.firing(), writer.asked()]
    text = "\n\n\n".join("\n".join(p) for p in parts) + "\n"
    plan_type = NamedTuple("Plan", [(k, np.ndarray) for k in plan_parts(made, have, numbers)])  # type: ignore[misc]
    space = execute(text, system.name, dict(writer.space))
    return Engine(made, have, plan_type, space, text, writer, numbers)
