"""A force controller simple enough to follow by hand, and the guard stepped on readings made by hand."""

import math
from typing import NamedTuple

from leadscrew.controllers._guard import CellChecks, force_guard
from leadscrew.kernel.block import controller
from leadscrew.references._cutting_program import CutCommand
from leadscrew.sensors._load_cell import CutReading

PERIOD = 0.02
COMMAND = CutCommand(150.0, 1.0, 1.0, 1e9)
NO_STILL = CellChecks(still_s=0.0)
"""Readings made by hand stand still."""


class ClimbParams(NamedTuple):
    """What the output grows by."""

    by: float = 0.01


class ClimbState(NamedTuple):
    """The last output."""

    output: float = 0.0


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    return ClimbState(output - params.by)


@controller(ClimbParams(), ClimbState(), align=align, unit="V", drive="voltage", full_scale=1.0)
def climb(p, s, command, feedback, dt):
    """An output that grows, whatever the force is."""
    return ClimbState(s.output + p.by), s.output + p.by


def reading(raw, force=None, k=0):
    """A reading; the filtered force is the raw one by default."""
    return CutReading(raw if force is None else force, raw, 0.01 * k, 0.4 * k)


class Stepped:
    """A controller stepped by hand, as plain Python."""

    def __init__(self, block, command=COMMAND, period=PERIOD, output=0.0):
        self.block, self.command, self.period = block, command, period
        self.p = block.params if block.prepare is None else block.prepare(block.params, period)
        self.s = block.state
        if output:
            self.s = block.align(self.p, command, reading(150.0), output)

    def __call__(self, raw, force=None):
        """The output for a reading."""
        return self.take(reading(raw, force))

    def take(self, feedback, command=None):
        """The output for a feedback."""
        self.s, output = self.block.step(self.p, self.s, command or self.command, feedback, self.period)
        return output

    @property
    def guard(self):
        """The guard's state."""
        return self.s.guard

    def numbers(self):
        """All numbers of the state."""
        return list(_numbers(self.s))

    def sound(self):
        """Whether all of them are finite."""
        return all(math.isfinite(x) for x in self.numbers())


def _numbers(value):
    for part in value:
        if isinstance(part, tuple):
            yield from _numbers(part)
        else:
            yield float(part)


def climbing(output=0.5, by=0.01, **parts):
    """A guarded :func:`climb`, stepped from an output on."""
    return Stepped(force_guard(climb(by=by), **({"cell": NO_STILL} | parts)), output=output)
