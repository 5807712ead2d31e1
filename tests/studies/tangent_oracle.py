"""A second, plain writing of the tangent-following loop of the study sofnn_tangent: nothing of Leadscrew is in it.

Plant, sensor, fuzzy network, table, performance network and Kalman learning from their equations, with dense matrices
and the Joseph form of the covariance. Order within a sample: plant, measure, learn, control. Angles in deg,
counter-clockwise positive; lengths in mm; a sample is 0.01 s and, at 50 mm/s, 0.5 mm. The shapes are cut here a second
time too: the wave by :class:`scipy.interpolate.BSpline`, the flower by its polar equation, the rectangle by hand.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import BSpline

T, FEED, FULL = 0.01, 50.0, 15.0
"""Sample time (s), feed (mm/s), largest offset (deg)."""
MATERIALS = {
    # shear S deg mm, lag tau s, fibre A deg, bias B deg, gain g
    "fabric": (45.0, 0.03, 1.0, 0.3, 0.95),
    "leather": (25.0, 0.02, 0.4, 0.8, 0.90),
    "foam": (90.0, 0.10, 0.2, 0.3, 0.75),
}

TABLE = np.array(
    [
        [6, 6, 6, 6, 5, 5, 0, 0, 0, 0, 0, 0, 0],
        [6, 6, 6, 5, 4, 4, 0, 0, 0, 0, 0, 0, 0],
        [6, 6, 5, 4, 3, 2, 0, 0, 0, 0, 0, 0, 0],
        [6, 6, 5, 4, 3, 2, 0, 0, 0, -2, -2, -2, 0],
        [6, 6, 5, 4, 1, 1, 0, 0, 0, -2, -4, -2, 0],
        [5, 5, 4, 3, 2, 1, 0, 0, 0, -3, -5, -3, 0],
        [4, 3, 3, 3, 2, 1, 0, -1, -2, -4, -4, -6, -6],
        [2, 3, 4, 3, 0, 0, 0, -1, -2, -4, -6, -6, -6],
        [0, 2, 3, 2, 0, 0, 0, -1, -2, -4, -6, -6, -6],
        [0, 2, 2, 2, 0, 0, 0, -2, -3, -4, -6, -6, -6],
        [0, 0, 0, 0, 0, 0, 0, -3, -4, -5, -6, -6, -6],
        [0, 0, 0, 0, 0, 0, 0, -4, -5, -5, -6, -6, -6],
        [0, 0, 0, 0, 0, 0, 0, -5, -6, -6, -6, -6, -6],
    ],
    dtype=float,
)
"""Table 1 of the paper: rows EC = -6..6, columns E = -6..6."""
GOLDEN = np.array(
    [
        [-1.629998, -2.371473, 6.735155],
        [-0.279553, 1.469397, 5.590288],
        [2.104603, 0.316268, -5.215608],
        [0.232047, 1.387691, -14.99985],
        [-1.067128, -1.845284, -14.9997],
        [-2.954066, -0.620146, -3.51835],
    ]
)
"""The safe 18-weight performance network: a row is a hidden unit, its weights of E and EC and its output weight."""


class Control(NamedTuple):
    """What one controller of the family is: gains, source of the correction, mode of learning."""

    k_e: float = 6.0 / 90.0  # level per deg
    k_ec: float = 6.0 / 90.0  # level per deg a sample
    k_d: float = 2.5  # deg per level
    learn: str = "stored"  # fixed; stored: equation 3 of the paper; accumulate
    source: int = 0  # 0 table bilinear, 2 the network
    kg: float = 1.0
    delay: int = 6  # samples by which the correction is referred back, m_c
    r: float = 0.01
    q: float = 0.05
    cap: float = 4.0
    clamp: float = 6.0
    filter_s: float = 0.05  # of the error's rate
    pid: tuple[float, float, float] | None = None  # a PID in the place of the network


FIXED = Control(learn="fixed")
LITERAL_TABLE = Control()
LITERAL_NET = Control(source=2)
TUNED = Control(k_e=6.0 / 45.0, learn="accumulate", kg=0.7)


def memberships(level: float) -> np.ndarray:
    """Seven triangles at -6, -4, ..., 6; the end sets saturate."""
    return np.maximum(0.0, 1.0 - np.abs(min(max(level, -6.0), 6.0) - np.arange(-6.0, 7.0, 2.0)) / 2.0)


def correction(source: int, e: float, ec: float) -> float:
    """P(E, EC) in levels."""
    if source == 2:
        hidden = np.tanh(GOLDEN[:, 0] * e / 6.0 + GOLDEN[:, 1] * ec / 6.0)
        return 6.0 * math.tanh(float(GOLDEN[:, 2] @ hidden))
    i, j = min(math.floor(ec) + 6, 11), min(math.floor(e) + 6, 11)
    a, b = ec + 6.0 - i, e + 6.0 - j
    return float(np.array([1 - a, a]) @ TABLE[i : i + 2, j : j + 2] @ np.array([1 - b, b]))


def learn(w: np.ndarray, p: np.ndarray, h: np.ndarray, innovation: float, c: Control) -> tuple[np.ndarray, np.ndarray]:
    """One dense Kalman update with the random walk, the cap on the diagonal and the clamp."""
    k = p @ h / (h @ p @ h + c.r)
    w = np.clip(w + k * innovation, -c.clamp, c.clamp)
    left = np.eye(49) - np.outer(k, h)
    p = left @ p @ left.T + c.r * np.outer(k, k)
    p = 0.5 * (p + p.T) + c.q * np.eye(49)
    scale = np.sqrt(np.minimum(1.0, c.cap / np.diag(p)))
    return w, p * np.outer(scale, scale)


class Cut(NamedTuple):
    """What :func:`cut` gives, a value a sample."""

    e: np.ndarray  # deviation, deg
    d: np.ndarray  # offset under which the sample was cut, deg
    lateral: np.ndarray  # mm


def cut(
    heading: np.ndarray,
    curvature: np.ndarray,
    control: Control | None,
    w0: np.ndarray,
    material: str = "fabric",
    later: str | None = None,
    change: int = 10**9,
    bias: float | None = None,
    texture: np.ndarray | None = None,
    noise: np.ndarray | None = None,
    sensor_delay: int = 4,
    waiting: int = 0,
) -> Cut:
    """Cut a path; ``control`` None sends no offset. ``texture`` adds to the steady shear angle (a step goes there).

    ``waiting``: samples that the controller runs before the first piece of the cut is there to be seen; they have
    ``noise`` too.
    """
    n = len(heading)
    texture = np.zeros(n) if texture is None else texture
    noise = np.zeros(waiting + n) if noise is None else noise
    e, d, lateral = np.zeros(n), np.zeros(n), np.zeros(n)
    gamma = x = rate = seen_before = offset = side = total = 0.0
    w = np.asarray(w0, float).ravel().copy()
    p = np.eye(49)
    rules, output = np.zeros((waiting + n, 49)), np.zeros(waiting + n)
    c = Control() if control is None else control
    a_x, a_f = math.exp(-T / 0.02), math.exp(-T / c.filter_s)
    for now in range(waiting + n):
        k = now - waiting
        # plant
        if k >= 0:
            shear, lag, fibre, own_bias, gain = MATERIALS[later if later and k >= change else material]
            load = shear * curvature[k] + fibre * math.sin(2 * math.radians(heading[k]))
            load += own_bias if bias is None else bias
            a = math.exp(-T / lag)
            gamma = a * gamma + (1 - a) * 14.0 * math.tanh((texture[k] - load) / 14.0)
            x = a_x * x + (1 - a_x) * offset
            e[k] = gain * x + gamma
            side += FEED * T * math.sin(math.radians(e[k]))
            lateral[k], d[k] = side, offset
        if control is None:
            continue
        # measure
        seen = (e[k - sensor_delay] if k >= sensor_delay else 0.0) + noise[now]
        rate = a_f * rate + (1 - a_f) * (seen - seen_before if now > 0 else 0.0)
        seen_before = seen
        if c.pid is not None:
            kp, ki, kd = c.pid
            wanted = -(kp * seen + total + ki * T * seen + kd * rate / T)
            offset = min(max(wanted, -FULL), FULL)
            total += ki * T * seen if wanted == offset else 0.0
            continue
        level, level_rate = min(max(c.k_e * seen, -6.0), 6.0), min(max(c.k_ec * rate, -6.0), 6.0)
        rules[now] = np.kron(memberships(level_rate), memberships(level))
        # learn
        if c.learn != "fixed" and now >= c.delay:
            g = c.kg * correction(c.source, level, level_rate)
            past = rules[now - c.delay]
            innovation = output[now - c.delay] + g - past @ w if c.learn == "stored" else g
            w, p = learn(w, p, past, innovation, c)
        # control
        output[now] = min(max(rules[now] @ w, -6.0), 6.0)
        offset = min(max(c.k_d * output[now], -FULL), FULL)
    return Cut(e, d, lateral)


def texture_of(n: int, step: float, generator: np.random.Generator) -> np.ndarray:
    """Ornstein-Uhlenbeck in arc length: 0.25 deg, 3 mm."""
    a = math.exp(-step / 3.0)
    x = 0.25 * generator.standard_normal(n)
    for k in range(1, n):
        x[k] = a * x[k - 1] + math.sqrt(1 - a * a) * x[k]
    return x


def wave(step: float = 0.5) -> tuple[np.ndarray, np.ndarray]:
    """Heading (deg) and curvature (1/mm) of the wave, a clamped cubic B-spline, every ``step`` mm of arc."""
    polygon = "0,0 25,55 60,60 80,10 105,-35 150,-30 160,20 175,65 225,60 240,15 270,-5 310,0"
    points = np.array([place.split(",") for place in polygon.split()], float)
    knots = np.r_[[0.0] * 3, np.linspace(0, 1, len(points) - 2), [1.0] * 3]
    curve = BSpline(knots, points, 3)
    return _sampled(curve.derivative(), curve.derivative(2), np.linspace(0, 1, 400_001), step)


def flower(step: float = 0.5) -> tuple[np.ndarray, np.ndarray]:
    """Heading and curvature of the closed flower r = 50 + 11 cos 5t."""
    turn = np.exp

    def first(t):
        z = (-55 * np.sin(5 * t) + 1j * (50 + 11 * np.cos(5 * t))) * turn(1j * t)
        return np.column_stack([z.real, z.imag])

    def second(t):
        z = (-275 * np.cos(5 * t) - 110j * np.sin(5 * t) - (50 + 11 * np.cos(5 * t))) * turn(1j * t)
        return np.column_stack([z.real, z.imag])

    return _sampled(first, second, np.linspace(0, 2 * np.pi, 400_001), step)


def rounded_rectangle(step: float = 0.5, laps: float = 1.5) -> tuple[np.ndarray, np.ndarray]:
    """Heading and curvature of the 100 x 60 mm rectangle with fillets of 10 mm, from a corner's end along a side."""
    quarter = 5 * np.pi
    lengths = np.array([80.0, quarter, 40.0, quarter] * 2)
    ends = np.cumsum(lengths)
    lap = ends[-1]
    s = np.arange(int(laps * lap / step)) * step
    piece = np.searchsorted(ends, s % lap, side="right")
    into = s % lap - np.r_[0.0, ends][piece]
    on_arc = piece % 2 == 1
    heading = 90.0 * (piece // 2) + np.where(on_arc, np.degrees(into / 10.0), 0.0) + 360.0 * (s // lap)
    return heading, np.where(on_arc, 0.1, 0.0)


def _sampled(first: Any, second: Any, u: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    speed = np.hypot(*first(u).T)
    travel = np.r_[0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(u))]
    at = np.interp(np.arange(int(travel[-1] / step)) * step, travel, u)
    (dx, dy), (ddx, ddy) = first(at).T, second(at).T
    heading = np.degrees(np.unwrap(np.arctan2(dy, dx)))
    return heading, (dx * ddy - dy * ddx) / np.hypot(dx, dy) ** 3
