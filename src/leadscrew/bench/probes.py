"""Loops that hold little but one function, to measure what it costs inside a compiled loop."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from leadscrew.controllers._vud.universe import CENTRES, TABLE_2
from leadscrew.fuzzy.inference import infer, rule_base
from leadscrew.kernel.block import Block, controller, plant, reference

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

STRIDE_X, STRIDE_Y = 0.7548776662466927, 0.5698402909980532
"""The R2 sequence: points that fill the square evenly, without a table or a generator."""


class Point(NamedTuple):
    """A point of the square [-1, 1] x [-1, 1]."""

    x: float = 0.0
    y: float = 0.0


class Total(NamedTuple):
    """Keeps what is computed from being optimised away."""

    sum: float = 0.0


@reference(Point(0.5, 0.5), Point())
def points(p, s):
    """The next point."""
    x, y = s.x + STRIDE_X, s.y + STRIDE_Y
    now = Point(x - 2.0 if x > 1.0 else x, y - 2.0 if y > 1.0 else y)
    return now, now


@plant(Total(), Total())
def idle(p, s, u, dt):
    """Sums up what it is given."""
    return Total(s.sum + u)


@controller(rule_base(CENTRES, CENTRES, TABLE_2), Total())
def fires(p, s, command):
    """The rules at the point."""
    return s, infer(p, command.x, command.y)


@controller(rule_base(CENTRES, CENTRES, TABLE_2), Total())
def fires_in_a_chain(p, s, command):
    """The rules at a point that waits for the last output."""
    out = infer(p, command.x + 1e-3 * s.sum, command.y)
    return Total(out), out


@controller(rule_base(CENTRES, CENTRES, TABLE_2), Total())
def adds(p, s, command):
    """What is left of the two above without the rules."""
    return s, command.x + command.y


@controller(Total(0.9))
def powers(p, command):
    """A power with an exponent that the compiler does not know."""
    return (command.x + 1.5) ** p.sum


@controller(Total(0.9))
def exponentials(p, command):
    """An exponential."""
    return math.exp(command.x * 3.0) * p.sum


@controller(Total(0.9))
def sines(p, command):
    """A sine."""
    return math.sin(command.x * 3.0) * p.sum


@controller(Total(0.9))
def nothing(p, command):
    """What is left of the three above without their function."""
    return command.x * 3.0 * p.sum


FUNCTIONS: dict[str, Block] = {"pow": powers, "exp": exponentials, "sin": sines}
INFERENCES: dict[str, Block] = {"throughput": fires, "dependent chain": fires_in_a_chain}


def probe(block: Block) -> Loop:
    """A loop around one of the controllers above."""
    from leadscrew.kernel.loop import Loop

    return Loop(reference=points, controller=block, plant=idle, period=0.001, metrics={}, name=block.name)


__all__ = ["FUNCTIONS", "INFERENCES", "adds", "nothing", "probe"]
