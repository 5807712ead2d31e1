"""What a transfer function with delay answers to an input that is held from sample to sample: exact, and fast.

    Y(s) / U(s) = s^k / D(s) * exp(-delay s),    k = 0 ... n - 1,    D of degree n

In companion form the states of ``1 / D(s)`` are all these at once. With ``delay = (l + f) T``, ``0 <= f < 1``, the
input of a period is ``u[k - l - 1]`` for ``f T`` and then ``u[k - l]``, so one step is (Astrom and Wittenmark,
*Computer-Controlled Systems*, 3rd ed., 1997, section 2.3)

    x[k + 1] = Phi x[k] + G0 u[k - l] + G1 u[k - l - 1]
    G0 = Gamma((1 - f) T),    G1 = Phi((1 - f) T) Gamma(f T)

with ``Phi(t) = e^(A t)`` and ``Gamma(t)`` the response to an input of one held over ``t``. Blocks of samples are
answered at once, by powers of the step: no loop over samples, and nothing is rounded off as in a filter's polynomials.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.plants._linear import hold_matrices

BLOCK = 64
"""Samples that are answered at once."""


class Step(NamedTuple):
    """One period of ``1 / D(s)`` with delay, state k being ``(s / rate)^k rate^n / D(s)``."""

    transition: np.ndarray
    now: np.ndarray
    """What an input of the newest sample that arrives adds, ``G0``."""
    before: np.ndarray
    """What the one before it adds, ``G1``."""
    whole: int
    """Whole periods of delay, ``l``."""
    rate: float
    """1/s: geometric mean of the poles that are not zero."""


def step_of(denominator: np.ndarray, delay_s: float, period: float) -> Step:
    """The step of a monic denominator, highest power first."""
    n = len(denominator) - 1
    known = np.flatnonzero(denominator)[-1]
    rate = float(abs(denominator[known]) ** (1.0 / known)) if known else 1.0 / period
    scaled = denominator / rate ** np.arange(n + 1.0)
    a = np.zeros((n, n))
    a[np.arange(n - 1), np.arange(1, n)] = rate
    a[-1] = -rate * scaled[:0:-1]
    b = np.zeros(n)
    b[-1] = rate
    whole = int(np.floor(delay_s / period + 1e-12))
    late = max(delay_s - whole * period, 0.0)
    transition, gamma = hold_matrices(a, b, period)
    if late == 0.0:
        return Step(transition, gamma, np.zeros(n), whole, rate)
    rest, now = hold_matrices(a, b, period - late)
    return Step(transition, now, rest @ hold_matrices(a, b, late)[1], whole, rate)


def forced(step: Step, u: np.ndarray, count: int | None = None) -> np.ndarray:
    """The first ``count`` states ``[sample, state]`` under ``u``, from rest; ``u`` had its first value before, too."""
    n = len(step.now)
    count = n if count is None else count
    now = np.concatenate([np.full(step.whole, u[0]), u])[: len(u)]
    blocks = -(-len(u) // BLOCK)
    inputs = np.zeros((blocks, BLOCK))
    inputs.ravel()[: len(u)] = now
    a = np.zeros((n + 1, n + 1))
    a[:n, :n], a[:n, n] = step.transition, step.before
    powers = np.empty((BLOCK + 1, n + 1, n + 1))
    powers[0] = np.eye(n + 1)
    for k in range(BLOCK):
        powers[k + 1] = powers[k] @ a
    answers = powers[:BLOCK] @ np.append(step.now, 1.0)
    x = np.zeros((blocks, n + 1))
    x[0, n] = u[0]
    ends, whole = inputs @ answers[::-1], powers[BLOCK].T.copy()
    for c in range(blocks - 1):
        x[c + 1] = x[c] @ whole + ends[c]
    states = np.einsum("kij,cj->cki", powers[:BLOCK, :count], x, optimize=True)
    lag = np.subtract.outer(np.arange(BLOCK), np.arange(BLOCK)) - 1
    for i in range(count):
        states[:, :, i] += inputs @ np.where(lag >= 0, answers[lag, i], 0.0).T
    return states.reshape(-1, count)[: len(u)]


def free(step: Step, samples: int) -> np.ndarray:
    """What each start of the states adds to state 0, ``[sample, state]``: the row ``e_0 Phi^k``."""
    rows = np.zeros((samples, len(step.now)))
    rows[0, 0] = 1.0
    done, power = 1, step.transition
    while done < samples:
        more = min(done, samples - done)
        rows[done : done + more] = rows[:more] @ power
        power, done = power @ power, done + more
    return rows


def sampled_response(step: Step, weights: np.ndarray, period: float, frequencies_hz: np.ndarray) -> np.ndarray:
    """Complex response from samples of the input to samples of the output, hold included; ``weights`` of the states."""
    z = np.exp(2j * np.pi * np.asarray(frequencies_hz) * period)
    left = z[:, None, None] * np.eye(len(step.now)) - step.transition
    arriving = step.now[None] + step.before[None] / z[:, None]
    states = np.linalg.solve(left, arriving[:, :, None])[:, :, 0]
    return (states @ weights) * z ** (-step.whole)
