"""Performance measurement of a self-organising fuzzy controller: how wrong was what it did, in levels.

A performance measurement decision table gives the correction ``P`` of the control quantity for a deviation ``E`` and
its change ``EC``, all three in levels of -6 to 6. :data:`TABLE` is Table 1 of the paper of the study ``sofnn_tangent``
(Deng, Liu, Wu, Zhang), rows ``EC``, columns ``E``, copied cell by cell (also where it is not odd and not monotone).
The paper stores it in a small network, its PNN, of ``h`` hidden neurons:

    x = (E, EC) / 6,    z_i = tanh(W_i . x + b_i),    y = sum v_i z_i + c
    P = 6 tanh(y)       or, linear,    P = y held to -6 .. 6

With ``b = 0`` and ``c = 0`` the network is exactly odd, so ``P(0, 0) = 0``, which a learning loop needs.

All functions here compile inside a block's step, and take ``E`` and ``EC`` of any size: they are held to -6 .. 6.
Training is in :mod:`leadscrew.neural.training`, what makes a network safe in :mod:`leadscrew.neural.safety`.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from leadscrew.kernel.sheet import Doc

MOST = 6.0
"""Outermost level."""
LEVELS = np.arange(-6.0, 7.0)
"""The 13 levels: of the columns (E) and of the rows (EC) of a table."""

BILINEAR, ROUNDED, NETWORK, ODD = 0, 1, 2, 3
"""Where the correction comes from, see :func:`correction`."""

FORMAT, VERSION = "leadscrew performance network", 1
"""What a file of a network says of itself."""

_HERE = Path(__file__).parent


class Performance(NamedTuple):
    """A performance network: two inputs, ``h`` hidden neurons, one output."""

    hidden: Annotated[np.ndarray, Doc("weights of E / 6 and EC / 6, one row a hidden neuron, (h, 2)")]
    hidden_bias: Annotated[np.ndarray, Doc("biases of the hidden neurons, (h,)")]
    out: Annotated[np.ndarray, Doc("weights of the hidden neurons in the output, (h,)")]
    out_bias: Annotated[float, Doc("bias of the output")] = 0.0
    linear: Annotated[bool, Doc("the output is linear and held, not 6 tanh")] = False


def _read_table() -> np.ndarray:
    values = np.loadtxt(_HERE / "performance_table.csv", delimiter=",", skiprows=1)[:, 1:]
    values.setflags(write=False)
    return values


def _read_golden() -> Performance:
    kept: dict[str, Any] = json.loads((_HERE / "performance_golden.json").read_text(encoding="utf-8"))
    return Performance(np.array(kept["hidden"]), np.array(kept["hidden_bias"]), np.array(kept["out"]))


TABLE = _read_table()
"""Table 1, 13 x 13: ``TABLE[EC + 6, E + 6]``."""
ODD_TABLE = 0.5 * (TABLE - TABLE[::-1, ::-1])
"""The odd part of Table 1, ``(T(E, EC) - T(-E, -EC)) / 2``."""
ODD_TABLE.setflags(write=False)
GOLDEN = _read_golden()
"""A safe network of 18 weights for Table 1: no biases, ``6 tanh`` output."""


def measured(net, e, ec):
    """Correction (levels) of the network at ``e`` and ``ec`` (levels)."""
    x = min(max(e, -MOST), MOST) / MOST
    y = min(max(ec, -MOST), MOST) / MOST
    total = net.out_bias
    for i in range(net.out.shape[0]):
        total = total + net.out[i] * math.tanh(net.hidden[i, 0] * x + net.hidden[i, 1] * y + net.hidden_bias[i])
    return min(max(total, -MOST), MOST) if net.linear else MOST * math.tanh(total)


def looked_up(table, e, ec):
    """Correction (levels) between the cells of a 13 x 13 table, bilinear."""
    x = min(max(e, -MOST), MOST) + MOST
    y = min(max(ec, -MOST), MOST) + MOST
    j = min(int(x), 11)
    i = min(int(y), 11)
    right = x - j
    up = y - i
    below = (1.0 - right) * table[i, j] + right * table[i, j + 1]
    above = (1.0 - right) * table[i + 1, j] + right * table[i + 1, j + 1]
    return (1.0 - up) * below + up * above


def looked_up_rounded(table, e, ec):
    """Correction (levels) of the nearest cell of a 13 x 13 table; half-way to the even level."""
    j = round(min(max(e, -MOST), MOST)) + 6
    i = round(min(max(ec, -MOST), MOST)) + 6
    return table[i, j]


def correction(kind, table, net, e, ec):
    """Correction (levels) from the source ``kind``.

    0 the table, bilinear; 1 its nearest cell; 2 the network; 3 the odd table, bilinear, which is then to be given as
    ``table``.
    """
    if kind == NETWORK:
        return measured(net, e, ec)
    if kind == ROUNDED:
        return looked_up_rounded(table, e, ec)
    return looked_up(table, e, ec)
