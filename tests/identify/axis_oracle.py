"""A second opinion on simulating and fitting a servo axis: plain Python and SciPy, nothing of the project.

    M dv/dt = u - offset - B v - C sgn(v),   dx/dt = v

With the push held over a period this has an exact solution between stops:

    v(t) = w + (v0 - w) exp(-B t / M)               w = (u - offset - s C) / B
    x(t) = x0 + w t + (v0 - w) (1 - exp(-B t / M)) M / B

The axis stops where v = 0, at t = (M / B) ln((v0 - w) / (-w)), and stays while abs(u - offset) <= C.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np


class Axis(NamedTuple):
    """kg, N s/m, N, N."""

    mass: float
    viscous: float
    coulomb: float
    offset: float


def moved(x: float, v: float, push: float, left: float, axis: Axis) -> tuple[float, float]:
    """Position and speed after ``left`` seconds under a held push, the offset already taken from it."""
    m, b, c, _ = axis
    for _stop in range(4):
        if v == 0.0 and abs(push) <= c:
            return x, 0.0
        side = math.copysign(1.0, v if v != 0.0 else push)
        w, decay = (push - side * c) / b, math.exp(-b * left / m)
        after = w + (v - w) * decay
        if after * side >= 0.0:
            return x + w * left + (v - w) * (1.0 - decay) * m / b, after
        stop = min(max(m / b * math.log((v - w) / -w), 0.0), left)
        x += w * stop + (v - w) * (1.0 - math.exp(-b * stop / m)) * m / b
        v, left = 0.0, left - stop
    return x, v


def open_loop(axis: Axis, force: np.ndarray, period: float, x: float, v: float = 0.0, delay: int = 0) -> np.ndarray:
    """Position at each sample from the logged force alone."""
    push = (force - axis.offset).tolist()
    rows = np.empty(len(push))
    for k in range(len(push)):
        rows[k] = x
        x, v = moved(x, v, push[max(k - delay, 0)], period, axis)
    return rows


def closed_loop(
    axis: Axis, command: np.ndarray, period: float, kp: float, kv: float, x: float, v: float = 0.0, over: int = 0
) -> np.ndarray:
    """Position at each sample under u = kv (kp (command - x) - speed), kv in force per speed.

    The speed is the axis's own, or the difference of its position over so many periods; before, it moved steadily.
    """
    rows = np.empty(len(command))
    past = [x - v * period * age for age in range(over, 0, -1)]
    for k, wanted in enumerate(command.tolist()):
        rows[k] = x
        speed = (x - past[-over]) / (over * period) if over else v
        past.append(x)
        x, v = moved(x, v, kv * (kp * (wanted - x) - speed) - axis.offset, period, axis)
    return rows


def rms(a: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(a))))


class Windowed(NamedTuple):
    """A fit over windows, each with a start of its own."""

    axis: Axis
    spread: Axis
    """Standard errors, robust: from the scatter of the windows' scores."""
    rms: float
    left: np.ndarray


STEPS = (1e-5, 1e-4, 1e-4, 1e-4)
"""Of the difference quotients, as shares of the values."""


def _piece(axis: Axis, force: np.ndarray, y: np.ndarray, period: float, start: list[float], delay: int) -> np.ndarray:
    return open_loop(axis, force, period, start[0], start[1], delay) - y


def windowed(
    force: np.ndarray, y: np.ndarray, period: float, guess: Axis, length: int, delay: int = 0, rounds: int = 12
) -> Windowed:
    """Gauss-Newton over all windows: own start position and speed for each, taken out by projection."""
    cuts = [slice(a, a + length) for a in range(0, len(y) - length + 1, length)]
    line = [np.polyfit(np.arange(9) * period, y[c][:9], 2) for c in cuts]
    starts = [[float(p[2]), float(p[1])] for p in line]
    scale, values = np.abs(np.array(guess)), np.array(guess, dtype=float)

    def look(at: np.ndarray, begin: list[list[float]]) -> tuple[list, list, list]:
        left, inner, outer = [], [], []
        for c, s in zip(cuts, begin, strict=True):
            f, z = force[c], y[c]
            r = _piece(Axis(*at), f, z, period, s, delay)
            du = [
                _piece(Axis(*(at + h * e * scale)), f, z, period, s, delay) - r
                for h, e in zip(STEPS, np.eye(4), strict=True)
            ]
            ds = [_piece(Axis(*at), f, z, period, [s[0] + a, s[1] + b], delay) - r for a, b in ((1e-6, 0), (0, 1e-4))]
            left.append(r)
            inner.append(np.column_stack(ds) / (1e-6, 1e-4))
            outer.append(np.column_stack(du) / np.array(STEPS))
        return left, inner, outer

    def total(at: np.ndarray, begin: list[list[float]]) -> float:
        rows = [_piece(Axis(*at), force[c], y[c], period, s, delay) for c, s in zip(cuts, begin, strict=True)]
        return sum(float(r @ r) for r in rows)

    cost = math.inf
    for _ in range(rounds):
        left, inner, outer = look(values, starts)
        free = [o - i @ np.linalg.lstsq(i, o, rcond=None)[0] for i, o in zip(inner, outer, strict=True)]
        normal = sum(f.T @ f for f in free)
        step = np.linalg.solve(normal, -sum(f.T @ r for f, r in zip(free, left, strict=True)))
        shift = [np.linalg.lstsq(i, -(r + o @ step), rcond=None)[0] for i, o, r in zip(inner, outer, left, strict=True)]
        cost = sum(float(r @ r) for r in left)
        for share in (1.0, 0.5, 0.25, 0.1, 0.03):
            at = values + share * step * scale
            begin = [[s[0] + share * d[0], s[1] + share * d[1]] for s, d in zip(starts, shift, strict=True)]
            if total(at, begin) < cost:
                values, starts = at, begin
                break
        else:
            break
        if np.abs(step).max() < 1e-6:
            break
    left, inner, outer = look(values, starts)
    free = [o - i @ np.linalg.lstsq(i, o, rcond=None)[0] for i, o in zip(inner, outer, strict=True)]
    bread = np.linalg.inv(sum(f.T @ f for f in free))
    scores = np.array([f.T @ r for f, r in zip(free, left, strict=True)])
    robust = bread @ (scores.T @ scores) @ bread
    spread = np.sqrt(np.diag(robust)) * scale
    return Windowed(Axis(*values), Axis(*spread), rms(np.concatenate(left)), np.concatenate(left))
