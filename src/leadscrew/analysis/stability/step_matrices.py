"""The matrices of a block's step: what it does to unit states and a unit input, as differences from its rest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.kernel.layout import Layout
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.noise import Noise

SMALL = 2.0**-30
"""Size of the unit: a power of two, so that the differences of a linear step from rest at zero carry no rounding."""
TRIED = (2.0**-20, 2.0**-12, 2.0**-7)
"""Sizes at which a step must be linear: 1 nm to 8 um for a loop in mm."""
LARGE = 1e4
"""Size at which a limit would show."""
EQUAL = 1e-9

Flat = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
"""State and input numbers to next state and output numbers."""


class Linear:
    """A block's matrices: ``x+ = a x + b u``, ``y = c x + d u``."""

    def __init__(self, f: Flat, order: int, inputs: int, rest: np.ndarray) -> None:
        def at(x: np.ndarray, u: np.ndarray) -> np.ndarray:
            return np.concatenate(f(rest + x, u))

        zero = at(np.zeros(order), np.zeros(inputs))
        size = SMALL if not zero.any() and not rest.any() else 1.0
        columns = []
        for k in range(order + inputs):
            z = np.zeros(order + inputs)
            z[k] = size
            columns.append((at(z[:order], z[order:]) - zero) / size)
        self.whole = np.array(columns).T.reshape(len(zero), order + inputs)
        self.order, self.inputs, self.outputs = order, inputs, len(zero) - order
        self.zero, self.at = zero, at
        a, b, _, _ = self.matrices
        reached = b.any(axis=1)
        for _ in range(order):
            reached = reached | ((a != 0.0) @ reached)
        self.live = np.concatenate([reached, np.ones(inputs, dtype=bool)])

    @property
    def matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """a, b, c, d."""
        n = self.order
        return self.whole[:n, :n], self.whole[:n, n:], self.whole[n:, :n], self.whole[n:, n:]

    def follows(self, size: float) -> bool:
        """Whether the step is the matrices' at states and inputs of this size, in two arbitrary directions.

        Only of states that the inputs reach: a flag of the first period stays as it is.
        """
        directions = np.cos(np.outer((1.7, 5.3), np.arange(1, self.order + self.inputs + 1))) * self.live
        for z in size * directions:
            expected = self.whole @ z
            seen = self.at(z[: self.order], z[self.order :]) - self.zero
            scale = np.abs(self.whole) @ np.abs(z) + 1e-300
            # next to values of the size of the rest point nothing finer than rounding can be seen
            if np.any(np.abs(seen - expected) > EQUAL * scale + 4e-16 * np.abs(self.zero)):
                return False
        return True

    def linear(self) -> bool:
        """Whether the step is linear at every size tried."""
        return all(self.follows(size) for size in TRIED)


def flat_step(
    loop: Loop, slot: str, given: Callable[[np.ndarray], dict[str, Any]], t: float
) -> tuple[Flat, int, np.ndarray]:
    """A block's step on plain numbers, how many its state has, and its state at rest."""
    block: Block = loop.blocks[slot]  # type: ignore[assignment]
    lead = [loop.prepared(block, slot)] if block.params is not None else []
    state = None if block.state is None else loop.start_state(block)
    layout = Layout(0.0 if state is None else state)
    scalars = len(layout.scalars) if state is not None else 0
    rest = np.zeros(0)
    if state is not None:
        s, v = layout.pack(state)
        rest = np.concatenate([s[:scalars], v[: layout.array_size]])
    noise = Noise(loop.seed, 0, 0, 0)
    dt = loop.step if slot == "plant" else loop.period

    def f(x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        signals = {"t": t, "dt": dt, "noise": noise, **given(u)}
        args = [signals[n] for n in block.signals]
        if state is None:
            return np.zeros(0), numbers(block.step(*lead, *args))
        held = layout.unpack(x[:scalars] if scalars else np.zeros(1), x[scalars:] if layout.array_size else np.zeros(1))
        result = block.step(*lead, held, *args)
        following, shown = (result, 0.0) if slot == "plant" else result
        s, v = layout.pack(following)
        moved = np.concatenate([s[:scalars], v[: layout.array_size]])
        return moved, np.zeros(0) if slot == "plant" else numbers(shown)

    return f, len(rest), rest


def numbers(signal: Any) -> np.ndarray:
    layout = Layout(signal if isinstance(signal, tuple) else float(signal))
    return layout.pack(signal)[0][: len(layout.scalars)].astype(float)


def filled(example: Any, numbers: np.ndarray) -> Any:
    return Layout(example).unpack(np.asarray(numbers, dtype=float), np.zeros(1))
