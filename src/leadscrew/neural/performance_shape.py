"""What a performance network is made of: hidden neurons, biases, output; and how many weights that is.

The paper of the study ``sofnn_tangent`` says of its network only ``P = 2 (2 + 6) = 16``. No network 2-6-1 has 16
weights: ``3 h`` without biases, ``h`` more with those of the hidden neurons, 1 more with that of the output.
:data:`READINGS` has those that were thought of. A row of weights is in the order ``W`` (row by row), ``b``, ``v``,
``c``; names as in :mod:`leadscrew.neural.performance`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from leadscrew.kernel.errors import NameUnknown, ValueRefused
from leadscrew.neural.performance import MOST, Performance

Biases = Literal["none", "output", "hidden", "all"]
BIASES: tuple[Biases, ...] = ("none", "output", "hidden", "all")
MOST_HIDDEN = 200


@dataclass(frozen=True)
class Shape:
    """A network 2-h-1.

    Raises:
        ValueRefused: no hidden neuron, or more than 200; biases of an unknown name.
    """

    hidden: int = 6
    biases: Biases = "none"
    linear: bool = False
    """The output is linear, not ``6 tanh``."""

    def __post_init__(self) -> None:
        if isinstance(self.hidden, bool) or not isinstance(self.hidden, int) or not 1 <= self.hidden <= MOST_HIDDEN:
            raise ValueRefused(f"hidden = {self.hidden!r} (performance network): expected 1 to {MOST_HIDDEN} neurons")
        if self.biases not in BIASES:
            raise ValueRefused(f"biases = {self.biases!r} (performance network): expected {', '.join(BIASES)}")

    @property
    def hidden_biases(self) -> int:
        """Number of biases in the hidden layer."""
        return self.hidden if self.biases in ("hidden", "all") else 0

    @property
    def out_biases(self) -> int:
        """Number of biases of the output, 0 or 1."""
        return 1 if self.biases in ("output", "all") else 0

    @property
    def weights(self) -> int:
        """Number of weights, biases included."""
        return 3 * self.hidden + self.hidden_biases + self.out_biases

    @property
    def name(self) -> str:
        """``2-6-1, no biases, tanh output``."""
        said = {"none": "no biases", "output": "output bias", "hidden": "hidden biases", "all": "all biases"}
        return f"2-{self.hidden}-1, {said[self.biases]}, {'linear' if self.linear else 'tanh'} output"

    def net(self, weights: Any) -> Performance:
        """The network of a row of weights."""
        w = np.asarray(weights, dtype=float)
        if w.shape != (self.weights,):
            raise ValueRefused(f"weights of shape {w.shape}: {self.name} has {self.weights}")
        hidden, bias, out, out_bias = self.parts(w[None])
        return Performance(hidden[0].copy(), bias[0].copy(), out[0].copy(), float(out_bias[0]), self.linear)

    def row(self, net: Performance) -> np.ndarray:
        """The weights of a network as a row."""
        parts = [np.ravel(net.hidden)]
        if self.hidden_biases:
            parts.append(np.ravel(net.hidden_bias))
        parts.append(np.ravel(net.out))
        if self.out_biases:
            parts.append(np.array([net.out_bias]))
        row = np.concatenate(parts).astype(float)
        if row.shape != (self.weights,):
            raise ValueRefused(f"a network of {row.size} weights: {self.name} has {self.weights}")
        return row

    def parts(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """``W (n, h, 2)``, ``b (n, h)``, ``v (n, h)``, ``c (n,)`` of ``n`` rows of weights."""
        n, h = rows.shape[0], self.hidden
        hidden = rows[:, : 2 * h].reshape(n, h, 2)
        bias = rows[:, 2 * h : 3 * h] if self.hidden_biases else np.zeros((n, h))
        at = 2 * h + self.hidden_biases
        out = rows[:, at : at + h]
        out_bias = rows[:, at + h] if self.out_biases else np.zeros(n)
        return hidden, bias, out, out_bias

    def outputs(self, rows: np.ndarray, points: np.ndarray) -> np.ndarray:
        """``P`` (levels, a linear output not held) of ``n`` rows of weights at ``m`` points ``(E, EC)``: ``(n, m)``."""
        hidden, bias, out, out_bias = self.parts(rows)
        z = np.tanh(hidden @ (points.T / MOST) + bias[:, :, None])
        y = np.matmul(out[:, None, :], z)[:, 0] + out_bias[:, None]
        return y if self.linear else MOST * np.tanh(y)

    def slopes(self, row: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """``P`` of one row of weights at ``m`` points, and its derivatives by the weights, ``(m, weights)``."""
        hidden, bias, out, out_bias = (part[0] for part in self.parts(row[None]))
        x = points / MOST
        z = np.tanh(x @ hidden.T + bias)
        y = z @ out + out_bias
        steep = out * (1.0 - z * z)
        columns = [(steep[:, :, None] * x[:, None, :]).reshape(len(x), -1)]
        if self.hidden_biases:
            columns.append(steep)
        columns.append(z)
        if self.out_biases:
            columns.append(np.ones((len(x), 1)))
        by_weights = np.concatenate(columns, axis=1)
        if self.linear:
            return y, by_weights
        p = np.tanh(y)
        return MOST * p, (MOST * (1.0 - p * p))[:, None] * by_weights


READINGS: dict[str, Shape] = {
    "18": Shape(6, "none"),
    "18_linear": Shape(6, "none", linear=True),
    "19": Shape(6, "output"),
    "24": Shape(6, "hidden"),
    "25": Shape(6, "all"),
    "16_four_hidden": Shape(4, "hidden"),
    "16_five_hidden": Shape(5, "output"),
}
"""Readings of the paper's count of 16 weights, by the number that they do have; ``18`` is ours."""


def reading(name: str) -> Shape:
    """The reading of this name.

    Raises:
        NameUnknown: there is none.
    """
    if name not in READINGS:
        raise NameUnknown(f"no reading {name!r} of the weight count; there are {', '.join(READINGS)}")
    return READINGS[name]


def shape_of(net: Performance) -> Shape:
    """The smallest shape that holds a network: a bias that is 0 is none."""
    hidden, output = bool(np.any(np.asarray(net.hidden_bias) != 0.0)), net.out_bias != 0.0
    biases: Biases = "all" if hidden and output else "hidden" if hidden else "output" if output else "none"
    return Shape(len(net.out), biases, bool(net.linear))


def surface(net: Performance, e: Any, ec: Any) -> np.ndarray:
    """``P`` (levels) of a network at arrays of ``E`` and ``EC`` (levels), as the block's step gives it."""
    e, ec = np.broadcast_arrays(np.asarray(e, float), np.asarray(ec, float))
    points = np.clip(np.column_stack([e.ravel(), ec.ravel()]), -MOST, MOST)
    shape = Shape(len(net.out), "all", bool(net.linear))
    p = shape.outputs(shape.row(net)[None], points)[0]
    return np.asarray(np.clip(p, -MOST, MOST).reshape(e.shape))
