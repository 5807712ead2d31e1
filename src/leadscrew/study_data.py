"""What a study is: loops by controller and scenario, and the claims that they are judged by.

A study is data about one published system. It holds no numerics of its own: blocks compute, loops run,
``analysis`` judges; the study says which, with which numbers, and what the paper printed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from leadscrew.kernel.parameters import checked_replace, nearest
from leadscrew.util.errors import NameUnknown, ValueRefused, entry_point

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.kernel.loop import Loop
    from leadscrew.studies.results import Contents


@dataclass(frozen=True)
class Scenario:
    """What is asked of the machine: its parameters (a NamedTuple with units and bounds) and one sentence."""

    name: str
    params: Any
    doc: str
    duration_s: float
    """How long a simulation of it runs by default."""


class Assumption(NamedTuple):
    """A number or a choice that the paper does not give."""

    what: str
    value: str
    why: str


@entry_point
@dataclass(frozen=True, repr=False)
class Study:
    """One published system."""

    name: str
    title: str
    paper: str
    """Full reference of the paper."""
    controllers: Mapping[str, Block]
    scenarios: Mapping[str, Scenario]
    build: Callable[[Block, Scenario], Loop]
    """The loop of a controller in a scenario."""
    folder: Path
    """Where ``paper_items.csv``, ``expected.csv`` and the paper's data lie."""
    contents: Callable[[], Contents] | None = None
    """Claims, experiments and figures: ``contents_of("leadscrew.studies.NAME.claims", ...)``."""
    summary: str = ""
    record: tuple[str, ...] = ()
    """Signals that runs record beside those that every run records."""
    card: tuple[str, ...] = ()
    """Three key claims, by their id without the study, for the study's card; the last ones unless given."""
    assumed: tuple[Assumption, ...] = ()
    method: tuple[str, ...] = ()
    """How the numbers came about, a paragraph each."""
    limits: tuple[str, ...] = ()
    """What the results do not say, a paragraph each."""

    def __repr__(self) -> str:
        return f"<Study {self.name}: {len(self.controllers)} controllers, {len(self.scenarios)} scenarios>"

    def judged(self) -> Contents:
        """What the study claims and shows.

        Raises:
            ValueRefused: it has no contents.
        """
        if self.contents is None:
            raise ValueRefused(f"{self.name} has no claims to judge: leadscrew simulate, compare or tune run it")
        return self.contents()

    def scenario(self, name: str, changes: Mapping[str, Any] | None = None) -> Scenario:
        """The scenario ``name`` with some of its parameters changed.

        Raises:
            NameUnknown, ValueRefused: no such scenario or parameter; a value out of range.
        """
        if name not in self.scenarios:
            raise NameUnknown(f"{self.name} has no scenario {name!r}{nearest(name, list(self.scenarios))}")
        found = self.scenarios[name]
        if not changes:
            return found
        params = checked_replace(found.params, changes, where=f"scenario {name}")
        return Scenario(found.name, params, found.doc, found.duration_s)

    def controller(self, name: str) -> Block:
        """The controller ``name`` of this study.

        Raises:
            NameUnknown: no such controller; names the nearest.
        """
        if name not in self.controllers:
            raise NameUnknown(f"{self.name} has no controller {name!r}{nearest(name, list(self.controllers))}")
        return self.controllers[name]

    def loop(self, controller: str | Block, scenario: str, changes: Mapping[str, Any] | None = None) -> Loop:
        """The loop of a controller in a scenario, with ``changes`` by dotted key (``scenario.*`` included)."""
        mine = {k.removeprefix("scenario."): v for k, v in (changes or {}).items() if k.startswith("scenario.")}
        rest = {k: v for k, v in (changes or {}).items() if not k.startswith("scenario.")}
        block = self.controller(controller) if isinstance(controller, str) else controller
        loop = self.build(block, self.scenario(scenario, mine))
        return loop.using(rest) if rest else loop
