"""Any linear plant, stepped by its exact zero-order-hold solution.

    dx/dt = A x + B u,   y = C x + D u        and over a period T with constant u:
    x+ = e^(A T) x + (integral_0^T e^(A s) ds) B u

:func:`state_space` takes the matrices, :func:`transfer_function` the polynomials in ``s``, highest power first. One
input, one output, any order. A direct feed-through ``D`` acts on the input that was held up to the sample: what a
sensor reads just before the controller answers.
"""

from __future__ import annotations

import hashlib
import sys
from importlib.metadata import version
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel import cache
from leadscrew.kernel.block import Block, plant
from leadscrew.kernel.parameters import Doc
from leadscrew.util.errors import ValueRefused, entry_point


class LinearParams(NamedTuple):
    """The matrices of the continuous plant, one input and one output."""

    a: Annotated[np.ndarray, Doc("state matrix, order by order")]
    b: Annotated[np.ndarray, Doc("input column")]
    c: Annotated[np.ndarray, Doc("output row")]
    d: Annotated[float, Doc("direct feed-through")] = 0.0


class LinearState(NamedTuple):
    """The state vector, a second one to work in, and the input held last."""

    x: np.ndarray
    work: np.ndarray
    held: float = 0.0


class LinearHold(NamedTuple):
    """The exact step over one period."""

    transition: np.ndarray
    drive: np.ndarray
    c: np.ndarray
    d: float


def hold_matrices(a: np.ndarray, b: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """``e^(A dt)`` and the response to an input of one held over ``dt``, from one matrix exponential of SciPy's.

    The first one of a process is kept in the cache beside the compiled loops: importing SciPy takes longer than a run.
    Once SciPy is there it is asked directly, as a batch over a plant's lags does a hundred thousand times.
    """
    order = len(a)
    joined = np.zeros((order + 1, order + 1))
    joined[:order, :order], joined[:order, order] = a, b
    joined *= dt
    exponential = _exponential(joined)
    return exponential[:order, :order], exponential[:order, order]


def _exponential(matrix: np.ndarray) -> np.ndarray:
    if "scipy.linalg" in sys.modules:
        from scipy.linalg import expm

        return np.ascontiguousarray(expm(matrix))
    name = f"hold_{hashlib.sha256(version('scipy').encode() + matrix.tobytes()).hexdigest()[:24]}.npy"
    kept = cache.read(name)
    if kept is not None and len(kept) == matrix.nbytes:
        return np.frombuffer(kept).reshape(matrix.shape)
    from scipy.linalg import expm

    found = np.ascontiguousarray(expm(matrix))
    cache.write(name, found.tobytes())
    return found


def linear_hold(params: LinearParams, dt: float) -> LinearHold:
    """The exact step of these matrices over ``dt``."""
    transition, drive = hold_matrices(params.a, params.b, dt)
    return LinearHold(np.ascontiguousarray(transition), np.ascontiguousarray(drive), params.c, params.d)


def read_out(p, s):
    """``C x + D u`` with the input held up to now."""
    y = p.d * s.held
    for i in range(s.x.shape[0]):
        y = y + p.c[i] * s.x[i]
    return y


def linear_step(p, s, u, dt):
    """State one period later under the constant input ``u``."""
    for i in range(s.x.shape[0]):
        total = p.drive[i] * u
        for j in range(s.x.shape[0]):
            total = total + p.transition[i, j] * s.x[j]
        s.work[i] = total
    for i in range(s.x.shape[0]):
        s.x[i] = s.work[i] if abs(s.work[i]) > 1e-30 else 0.0
    return LinearState(s.x, s.work, u)


@entry_point
def state_space(a, b, c, d: float = 0.0, name: str = "linear") -> Block:
    """The plant ``dx/dt = A x + B u``, ``y = C x + D u`` with one input and one output.

    Raises:
        ValueRefused: matrices that do not fit together, or that are not finite.
    """
    a = np.atleast_2d(np.array(a, dtype=float))
    b, c = np.array(b, dtype=float).ravel(), np.array(c, dtype=float).ravel()
    order = len(a)
    if a.shape != (order, order) or b.size != order or c.size != order or order == 0:
        raise ValueRefused(
            f"{name}: A {a.shape}, B {b.size} and C {c.size} do not fit: a plant of order n with one input and one "
            "output has A n by n, and n numbers each in B and C"
        )
    if not all(np.isfinite(m).all() for m in (a, b, c, np.array(d))):
        raise ValueRefused(f"{name}: the matrices hold a value that is not finite")
    params, state = LinearParams(a, b, c, float(d)), LinearState(np.zeros(order), np.zeros(order))
    return plant(params, state, output=read_out, prepare=linear_hold, name=name)(linear_step)


@entry_point
def transfer_function(numerator, denominator, name: str = "linear") -> Block:
    """The plant with this transfer function in ``s``, coefficients from the highest power down.

    Raises:
        ValueRefused: a numerator of higher degree than the denominator, or a denominator that is zero.
    """
    from scipy.signal import tf2ss

    num, den = np.trim_zeros(np.atleast_1d(numerator), "f"), np.trim_zeros(np.atleast_1d(denominator), "f")
    if len(den) == 0:
        raise ValueRefused(f"{name}: the denominator is zero")
    if len(num) > len(den):
        raise ValueRefused(f"{name}: the numerator's degree {len(num) - 1} exceeds the denominator's {len(den) - 1}")
    if len(den) == 1:
        raise ValueRefused(f"{name}: a constant has no state; scale the controller's output instead")
    a, b, c, d = tf2ss(num if len(num) else [0.0], den)
    return state_space(a, b, c, float(np.ravel(d)[0]), name)
