"""Trials of a controller by its own step: its answer to errors at rest, and whether a command changes it.

A controller is a part of a Lur'e loop where its output is what the command alone makes, plus what the error makes:

    u(r, r - e) - u(r, r) = u(0, -e) - u(0, 0)            for every command r and every row of errors e

A feed-forward, the weights of a 2-DOF controller and a look-ahead add what the command makes and pass. A gain that is
scheduled on the command, and shares that are learned from the error times the command, do not.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.kernel.errors import ValueRefused

LENGTH = 60
"""Periods of each trial of a controller's answer."""

LONG = 2000
"""Periods of the one long trial under a command: 1 s at 2 kHz."""

ALIKE = 1e-8
"""Two answers are the same up to this, relative to the largest value: rounding of unlike orders of computation."""

ROUNDING = 1e-13
"""What rounding leaves of a known output, relative to it."""

MOVES = (
    (0.0, 0.008, 5.0),
    (0.0, 1.0, 0.7),
    (-10.0, 3.0, 12.0),
    (2.0, -0.2, 60.0),
    (-200.0, 300.0, 1.0),
    (15.0, 0.0, 0.0),
)
"""Commands: offset in mm, amplitude in mm, frequency in Hz. From 8 um to 0.3 m, up to 1.9 m/s, of both signs."""

LONG_MOVE = (1.0, 1.0, 2.1)
"""The command of the long trial."""


def moved_by_command(block: Block, sizes: tuple[float, ...], rng: np.random.Generator, period: float) -> str | None:
    """The first command under which the block answers an error otherwise than at rest, in words; None where none is.

    ``sizes`` of the errors in mm.
    """
    trials = [(move, LENGTH, sizes) for move in MOVES]
    for move, length, each in (*trials, (LONG_MOVE, LONG, sizes[-1:])):
        r = moving(move, length, period)
        alone = answer(block, np.zeros(length), period, r)
        known = answer(block, np.zeros(length), period)
        for size in each:
            errors = size * rng.normal(size=length)
            at_rest = answer(block, errors, period) - known
            whole = float(np.abs(at_rest).max())
            if not math.isfinite(whole):  # an unstable controller runs away by itself in the long trial
                continue
            under = answer(block, errors, period, r) - alone
            rounding = ROUNDING * float(np.abs(alone).max() + np.abs(known).max())
            if not float(np.abs(under - at_rest).max()) <= ALIKE * whole + rounding:
                return words(move)
    return None


def words(move: tuple[float, float, float]) -> str:
    """A command for a sentence."""
    offset, amplitude, hz = move
    if not hz:
        return f"a command that stands at {offset:g} mm"
    around = f" around {offset:g} mm" if offset else ""
    return f"a command that moves by {abs(amplitude):g} mm at {hz:g} Hz{around}"


def moving(move: tuple[float, float, float], length: int, period: float) -> np.ndarray:
    """Position, velocity and acceleration of a command, a row for each period."""
    offset, amplitude, hz = move
    w = 2.0 * math.pi * hz
    t = period * np.arange(length)
    wave, turned = amplitude * np.sin(w * t), amplitude * np.cos(w * t)
    return np.column_stack([offset + wave, w * turned, -w * w * wave])


def answer(block: Block, errors: np.ndarray, period: float, commands: np.ndarray | None = None) -> np.ndarray:
    """Outputs of a block at rest to a row of errors, by its own step; NaN where the step has no number.

    ``commands``: a row of position, velocity and acceleration for each error; a controller of a number gets the
    position. At rest without.

    Raises:
        ValueRefused: a controller of several axes.
    """
    plan = block.params if block.prepare is None else block.prepare(block.params, period)
    state = block.state if block.initial is None else block.initial(block.params)
    moves = np.zeros((len(errors), 3)) if commands is None else commands
    for given in _as_numbers(moves), _as_motions(moves):
        s, out = copy.deepcopy(state), []
        try:
            for k, (command, error) in enumerate(zip(given, errors, strict=True)):
                now = {
                    "command": command, "feedback": float(moves[k, 0] - error), "t": k * period, "dt": period
                }  # fmt: skip
                done = block.step(*(x for x in (plan, s) if x is not None), *(now[name] for name in block.signals))
                s, u = done if block.state is not None else (None, done)
                out.append(float(u))
        except (AttributeError, TypeError):
            continue
        except (ArithmeticError, ValueError):
            return np.full(len(errors), np.nan)
        return np.array(out)
    raise ValueRefused(
        f"{block.name} takes or gives several numbers where a loop of one axis has one position, one feedback and one "
        "output; take apart one axis of it"
    )


def _as_numbers(moves: np.ndarray) -> Iterator[float]:
    return (float(row[0]) for row in moves)


def _as_motions(moves: np.ndarray) -> Iterator[object]:
    from leadscrew.references._motion import Motion

    return (Motion(*(float(x) for x in row)) for row in moves)
