"""Controllers taken period by period in plain Python: what a loop would give them, without compiling one."""

import math
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from leadscrew.controllers._parts import follow
from leadscrew.fuzzy.views import Now
from leadscrew.kernel.block import Block
from leadscrew.kernel.by_position import prepared
from leadscrew.kernel.layout import copied
from leadscrew.operate.why import explained


class Period(NamedTuple):
    """One period of a controller, and its explanation."""

    before: Any
    after: Any
    """Its state, that of the controller inside it where it is wrapped."""
    command: Any
    feedback: Any
    output: float
    views: dict[str, Any]
    plan: Any
    """What its step gets as parameters."""


def row_of(**signals: Any) -> dict[str, float]:
    """A row of signals: fields with dots."""
    found = {}
    for name, value in signals.items():
        if hasattr(value, "_fields"):
            found |= {f"{name}.{k}": float(v) for k, v in zip(value._fields, value, strict=True)}
        else:
            found[name] = float(value)
    return found


def periods(block: Block, signals: Callable[[int], tuple[Any, Any]], dt: float, count: int) -> Iterator[Period]:
    """The periods of a controller under ``signals(k) -> (command, feedback)``."""
    found = explained(block)
    assert found is not None, f"{block.name} has no explanation"
    part, view = found
    plan = prepared(block, dt)
    state = copied(block.initial(block.params) if block.initial is not None else block.state)
    for k in range(count):
        command, feedback = signals(k)
        before = copied(state)
        state, output = block.step(plan, state, command, feedback, dt)
        own = follow(block.params, part.params), follow(state, part.state)
        views = view.look(Now(*own, row_of(command=command, feedback=feedback, output=output), dt))
        yield Period(follow(before, part.state), own[1], command, feedback, output, views, plan)


def said(views: dict[str, Any]) -> float:
    """What the shown shares and values add up to."""
    return math.fsum(r["share"] * r["value"] for r in views["rules"]["rules"])


def value_of(views: dict[str, Any], name: str) -> float:
    """An output among the shown ones."""
    found = [o["value"] for o in views["rules"]["outputs"] if o["name"] == name]
    assert len(found) == 1, name
    return float(found[0])


def check_shares(views: dict[str, Any]) -> None:
    """Shares sum to one; the rules come the strongest first; the degrees of the sets are memberships."""
    shares = [r["share"] for r in views["rules"]["rules"]]
    assert math.isclose(math.fsum(shares), 1.0, rel_tol=1e-12)
    assert shares == sorted(shares, reverse=True)
    for quantity in views["sets"]["inputs"]:
        for one in quantity["sets"]:
            xs, ys = np.array(one["points"]).T
            assert (np.diff(xs) >= 0.0).all()
            at = float(np.interp(quantity["value"], xs, ys))
            assert math.isclose(at, one["degree"], abs_tol=1e-9), (quantity["name"], one["name"])
