"""Random servo axes with known parameters, simulated by nothing of the project: NumPy, all axes of a call at once.

    M dv/dt = u(t - delay) - offset - F(v),   dx/dt = v,   F = sgn(v) (C + (S - C) exp(-(v/v_s)^2)) + B v

with values of F for each direction. The drive is held from sample to sample. The delay is any number: each period is
cut where the delayed drive jumps. Each part is taken in steps of about 0.1 ms by the midpoint rule; where the speed
passes zero within a step, the rest of the step begins from rest: the axis stays there while the push is no larger than
the static friction of its direction. `tests/identify/test_truth.py` compares this with SciPy's `solve_ivp`.

Each axis is under a cascade (position P, speed P or PI with a filtered difference of the *measured* position, some with
feed-forward), so the encoder's noise and rounding reach the drive, as on a machine.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

PERIOD = 1e-3
STEPS = 6
"""Of the integration in each of the two parts of a period."""
POOR = ("one_way", "no_acceleration", "one_speed")
SIDES = ("forward", "backward")
LEAD = 628.0
"""rad per m of a screw of 10 mm: turns a linear axis into a rotary one."""
WELL = ("mass", *(f"friction.{s}.{n}" for s in SIDES for n in ("coulomb", "viscous")))


@dataclass(frozen=True)
class Truth:
    """A log and what is behind it."""

    seed: int
    kind: str
    """`coulomb` or `stribeck`; of :data:`POOR`, what the log lacks, after a slash."""
    symmetric: bool
    time: np.ndarray
    drive: np.ndarray
    position: np.ndarray
    command: np.ndarray
    position_unit: str
    drive_unit: str
    values: dict[str, float]
    """True values by key, in the drive's unit and the position's."""
    excites: frozenset[str]
    """Keys of which any good method must find a useful interval."""
    cascade: dict[str, float]
    encoder_step: float
    about: dict[str, float] = field(default_factory=dict)

    def log(self) -> Any:
        """As the product takes it."""
        from leadscrew.logs.arrays import axis_log

        return axis_log(self.time, self.drive, self.position, self.command, position_unit=self.position_unit,
                        drive_unit=self.drive_unit, source=f"truth {self.seed}")  # fmt: skip


def _moves(r: np.random.Generator, lack: str, top: float, acceleration: float, length: int) -> np.ndarray:
    """Commanded speed by sample: moves at several speeds both ways with rests between, and a slow part."""
    rows, side, total, n = [np.zeros(int(0.2 / PERIOD))], 1.0, 0.0, 0
    slow = min(float(r.uniform(0.003, 0.01)), 0.2 * top)
    shares = [1.0, 0.5, 0.2, -1.0, 0.08, 0.75, 0.35]
    while total < length:
        share = 1.0 if lack == "one_speed" else shares[(n // 2) % len(shares)]
        v = slow if share < 0.0 else share * top * float(r.uniform(0.85, 1.0))
        a = acceleration * float(r.uniform(0.5, 1.0)) if lack != "one_speed" else acceleration
        ramp = np.arange(1, max(int(v / a / PERIOD), 1) + 1) / max(int(v / a / PERIOD), 1) * v
        hold = np.full(int(r.uniform(0.15, 0.6) / PERIOD) * (2 if v == slow else 1), v)
        rows += [side * np.concatenate([ramp, hold, ramp[::-1]]), np.zeros(int(r.choice([0.0, 0.05, 0.2]) / PERIOD))]
        total += len(rows[-1]) + len(rows[-2])
        side, n = (side if lack == "one_way" else -side), n + 1
    speed = np.concatenate(rows)[:length]
    smooth = int(r.integers(5, 40))
    return np.convolve(speed, np.full(smooth, 1.0 / smooth))[:length]


def _axis(seed: int, lack: str | None) -> dict[str, Any]:
    """One axis drawn at random: everything that its simulation needs."""
    r = np.random.default_rng([seed, 11])
    if lack is None:
        lack = POOR[seed // 10 % 3] if seed % 10 == 9 else ""
    top = float(np.exp(r.uniform(np.log(0.05), np.log(0.5))))
    acceleration = float(np.exp(r.uniform(np.log(max(0.5, 2.0 * top)), np.log(10.0))))
    mass = float(np.exp(r.uniform(np.log(5.0), np.log(300.0))))
    force = mass * acceleration
    if lack == "no_acceleration":
        acceleration, force = float(r.uniform(0.01, 0.03)), 0.05 * force
    share = r.uniform(0.05, 0.3)
    coulomb = force * share / (1.0 - share)
    viscous = force * float(r.uniform(0.02, 0.15)) / top
    stribeck, symmetric = bool(r.integers(2)), bool(r.integers(2))
    rise, fall = (float(r.uniform(1.1, 1.6)) if stribeck else 1.0), float(r.uniform(0.003, 0.015))
    unlike = np.zeros(2) if symmetric else np.array([1.0, -1.0]) * r.uniform(0.05, 0.2)
    unlike_viscous = np.zeros(2) if symmetric else np.array([1.0, -1.0]) * r.uniform(-0.2, 0.2)
    c, b = coulomb * (1.0 + unlike), viscous * (1.0 + unlike_viscous)
    step = float(np.exp(r.uniform(np.log(1e-7), np.log(1e-5))))
    speed_loop = 2.0 * np.pi * float(r.uniform(8.0, 30.0)) * (1.0 if step < 2e-6 else 0.5)
    length = int(r.uniform(12.0, 25.0) / PERIOD)
    ahead = _moves(r, lack, top, acceleration, length)
    largest = 3.0 * (force + 2.0 * coulomb + viscous * top)
    return {
        "seed": seed, "lack": lack, "top": top, "acceleration": acceleration, "mass": mass, "symmetric": symmetric,
        "stribeck": stribeck, "c": c, "s": c * rise, "vs": np.array([fall, fall]), "b": b,
        "offset": float(r.uniform(-0.2, 0.2)) * coulomb,
        "delay": 0.0 if r.integers(2) else float(r.uniform(0.0, 3.0)) * PERIOD,
        "step": step, "noise": step * float(r.choice([0.1, 0.4, 1.0])) * r.standard_normal(length), "length": length,
        "speed": ahead, "kp": speed_loop / float(r.uniform(3.0, 6.0)), "kv": speed_loop * mass,
        "ki": float(r.choice([0.0, 0.2])) * speed_loop, "lag": 1.0 / (2.0 * np.pi * float(r.uniform(80.0, 250.0))),
        "ahead": float(r.choice([0.0, 1.0])), "dac": largest / 2.0 ** int(r.integers(11, 16)), "largest": largest,
        "exact": bool(r.integers(2)), "rotary": seed % 8 == 7, "unscaled": seed % 8 == 5,
    }  # fmt: skip


def _slide(x: np.ndarray, v: np.ndarray, push: np.ndarray, h: np.ndarray, p: dict[str, np.ndarray]) -> tuple:
    """Position, speed after ``h`` and what is left of ``h`` where the axis came to rest within it."""
    side = np.where(v != 0.0, np.sign(v), np.where(push > p["s0"], 1.0, np.where(push < -p["s1"], -1.0, 0.0)))
    ahead = side >= 0.0
    c, more = np.where(ahead, p["c0"], p["c1"]), np.where(ahead, p["d0"], p["d1"])
    b, fall = np.where(ahead, p["b0"], p["b1"]), np.where(ahead, p["i0"], p["i1"])

    def rate(w: np.ndarray) -> np.ndarray:
        return np.where(side == 0.0, 0.0, (push - side * (c + more * np.exp(-(w * w) * fall)) - b * w) / p["mass"])

    half = v + 0.5 * h * rate(v)
    after = v + h * rate(half)
    turned = after * side < 0.0
    if not turned.any():
        return x + 0.5 * h * (v + after), after, None
    at = np.where(turned, h * v / np.where(turned, v - after, 1.0), h)
    for _ in range(2):
        pull = rate(v + 0.5 * at * rate(v))
        at = np.where(turned, np.clip(at - (v + at * pull) / np.where(pull != 0.0, pull, 1.0), 0.0, h), h)
    after = np.where(turned, 0.0, after)
    return x + 0.5 * at * (v + after), after, np.where(turned, h - at, 0.0)


def advance(x: np.ndarray, v: np.ndarray, push: np.ndarray, h: np.ndarray, p: dict[str, np.ndarray]) -> tuple:
    """Position and speed after ``h`` under a held push, with stops and starts."""
    x, v, left = _slide(x, v, push, h, p)
    for _ in range(3):
        if left is None:
            return x, v
        # where nothing is left, nothing moves: h = 0
        x, v, left = _slide(x, v, push, left, p)
    return x, v


def laws(axes: list[dict[str, Any]]) -> dict[str, np.ndarray]:
    """Friction of the axes by direction, as arrays over the axes."""
    p = {"mass": np.array([a["mass"] for a in axes])}
    for i in range(2):
        p[f"c{i}"], p[f"s{i}"], p[f"b{i}"] = (np.array([a[n][i] for a in axes]) for n in "csb")
        p[f"d{i}"] = p[f"s{i}"] - p[f"c{i}"]
        p[f"i{i}"] = 1.0 / np.array([a["vs"][i] for a in axes]) ** 2
    return p


def _simulate(axes: list[dict[str, Any]], steps: int = STEPS) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    n, length = len(axes), max(a["length"] for a in axes)

    def table(name: str) -> np.ndarray:
        rows = np.zeros((length, n))
        for i, a in enumerate(axes):
            rows[: a["length"], i] = a[name]
        return rows

    def row(name: str) -> np.ndarray:
        return np.array([float(a[name]) for a in axes])

    p, speed, noise, step, dac = laws(axes), table("speed"), table("noise"), row("step"), row("dac")
    command = np.cumsum(speed, axis=0) * PERIOD
    rise = np.gradient(speed, PERIOD, axis=0) * p["mass"] * row("ahead")
    kp, kv, ki, ahead, most, exact = (row(k) for k in ("kp", "kv", "ki", "ahead", "largest", "exact"))
    keep, offset = np.exp(-PERIOD / np.maximum(row("lag"), 1e-9)), row("offset")
    whole = np.floor(row("delay") / PERIOD)
    part = row("delay") - whole * PERIOD
    past = whole.astype(int)
    x, v, felt, total, before = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    position, applied = np.zeros((length, n)), np.zeros((length + 8, n))
    every = np.arange(n)
    for k in range(length):
        seen = np.round((x + noise[k]) / step) * step
        felt = keep * felt + (1.0 - keep) * (seen - before) / PERIOD
        before, error = seen, kp * (command[k] - seen) + ahead * speed[k] - felt
        total = total + ki * PERIOD * error
        u = np.clip(kv * (error + total) + rise[k], -most, most)
        applied[k + 8] = np.where(exact > 0.0, np.round(u / dac) * dac, u)
        position[k] = seen
        old, new = applied[k + 7 - past, every] - offset, applied[k + 8 - past, every] - offset
        h = part / steps
        for _ in range(steps if part.any() else 0):
            x, v = advance(x, v, old, h, p)
        h = (PERIOD - part) / steps
        for _ in range(steps):
            x, v = advance(x, v, new, h, p)
    return position, np.round(applied[8:] / dac) * dac, command


def _truth(a: dict[str, Any], position: np.ndarray, drive: np.ndarray, command: np.ndarray) -> Truth:
    n, turn = a["length"], LEAD if a["rotary"] else 1.0
    scale = 0.05 / a["dac"] / 2**8 if a["unscaled"] else 1.0 / turn
    values = {"mass": a["mass"] * scale / turn, "offset": a["offset"] * scale, "delay_s": a["delay"], "backlash": 0.0}
    for i, side in enumerate(SIDES):
        values[f"friction.{side}.coulomb"] = float(a["c"][i]) * scale
        values[f"friction.{side}.viscous"] = float(a["b"][i]) * scale / turn
        values[f"friction.{side}.static"] = float(a["s"][i]) * scale
        values[f"friction.{side}.stribeck_speed"] = float(a["vs"][i]) * turn
    return Truth(
        seed=a["seed"], kind=("stribeck" if a["stribeck"] else "coulomb") + (f"/{a['lack']}" if a["lack"] else ""),
        symmetric=a["symmetric"], time=np.arange(n) * PERIOD, drive=drive[:n] * scale, position=position[:n] * turn,
        command=command[:n] * turn, position_unit="rad" if a["rotary"] else "m",
        drive_unit="V" if a["unscaled"] else "N m" if a["rotary"] else "N", values=values,
        excites=frozenset() if a["lack"] else frozenset(WELL), encoder_step=a["step"] * turn,
        cascade={"kp": a["kp"], "kv": a["kv"] * scale / turn, "ki": a["ki"], "lag_s": a["lag"], "ahead": a["ahead"]},
        about={k: float(a[k]) for k in ("top", "acceleration", "dac", "largest")},
    )  # fmt: skip


@lru_cache(maxsize=4)
def truths(seeds: tuple[int, ...], lack: str | None = None, steps: int = STEPS) -> tuple[Truth, ...]:
    """Axes of these seeds, 10 s for a hundred; every tenth lacks something (:data:`POOR`), unless ``lack`` says what.

    An axis does not depend on which others are simulated with it. Every eighth is rotary, every eighth has a drive of
    unknown scale: its values are in volts.
    """
    axes = [_axis(seed, lack) for seed in seeds]
    position, drive, command = _simulate(axes, steps)
    return tuple(_truth(a, position[:, i], drive[:, i], command[:, i]) for i, a in enumerate(axes))


def truth(seed: int, lack: str | None = None) -> Truth:
    """One axis."""
    return truths((seed,), lack)[0]
