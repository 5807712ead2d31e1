"""One search for every law: the smallest mean row of Table II under the same bounds.

Every law here is a PID for small errors and a PID for large ones; around any error the loop is that of

    (1 - s) C_small + s C_large,      0 <= s <= 1

``pid``: both are the same. ``npid``: ``C_large`` is ``C_small`` times the steepest slope of ``K(e) e``. ``npid_split``:
its quiet and its firm path. ``pid_low_pass`` is a PID behind a low-pass of second order in place of the filter of its
derivative, ``pid_lag`` that with a lag besides: linear laws of five and of seven gains.

Goal: mean of the fifteen rows of Table II, simulated on the nominal axis with encoder, runout and tooth passing, under
:data:`DRAWS` draws of the forces' phases at three spindle speeds. Bounds: the peak of sensitivity Ms at every ``s``; on
each of the twelve plants of the box the loop of ``C_small`` is stable and the circle criterion holds for all that
``s`` does in time (a linear law has nothing to prove beyond its poles); rms change of the output from sample to sample
at rest, or at work.

CMA-ES of :mod:`leadscrew.tune.optimisers` in the logarithms, from the middle of the ranges; the same budget and seed
for every law.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from leadscrew.controllers._biquad import LeadLag, LowPass, coefficients
from leadscrew.controllers._npid import npid
from leadscrew.controllers._npid_split import npid_split
from leadscrew.kernel.block import Block
from leadscrew.studies.lab import Lab
from leadscrew.studies.npid_xytable.calibration import PERIOD_S
from leadscrew.studies.npid_xytable.controllers import LINEAR
from leadscrew.studies.npid_xytable.cutting import BOX, amplitudes_um, line_volts, phases_of
from leadscrew.studies.npid_xytable.rejection import opened
from leadscrew.studies.npid_xytable.table2 import SPEEDS
from leadscrew.studies.npid_xytable.tunings import fed_forward, table_pid

MS, REST_MV, WORK_MV = 1.6, 0.5, 2.0
"""Bounds of the study: peak of sensitivity, and activity of the drive at rest or at work, mV from sample to sample."""
BUDGET, SEED = 3000, 1
DRAWS, DRAW_SEED, HELD_OUT = 2, 7, 4
"""Of the phases that the search sees, and of those that it does not: ``phases_of`` with seed 1, which the study has."""
RUN_S, EVERY = 6.0, 4
ROOM = 1.02
"""Slope of ``s`` up to which the circle criterion has to hold on the grid of frequencies; 1 is needed."""
NEAR, STEEP, RESERVE = 0.1, 10.0, 0.98
"""Part by which Ms may be missed for a setting to be simulated; what a missed bound costs, in logarithms of the row;
part of an activity that the search uses, because noise differs from run to run."""

PATH = {"kp": (0.1, 4.0), "ki": (5.0, 1500.0), "kd": (5e-4, 2e-2), "filter_s": (2e-5, 5e-3)}
Ends = tuple[np.ndarray, np.ndarray]
Settings = Mapping[str, np.ndarray]


class Law(NamedTuple):
    """A law, what its search may change, and its PIDs for small and for large errors, ``(4, settings)`` each."""

    block: Block
    ranges: Mapping[str, tuple[float, float]]
    ends: Callable[[Settings], Ends]
    sections: Callable[[Settings, int], Sequence[LowPass | LeadLag]] = lambda values, i: ()
    """Filters behind the PID in setting ``i``."""

    def peaks(self, values: Settings) -> tuple[np.ndarray, np.ndarray]:
        """Ms at every ``s`` on the nominal axis, and the largest on the box."""
        ends, filters = self.ends(values), self.filters(values, responses()[0])
        return largest_ms(ends, filters), worst_ms(self, values)

    def filters(self, values: Settings, z: np.ndarray) -> np.ndarray:
        """Response of the filters, ``(settings, frequencies)``."""
        rows = []
        for i in range(len(next(iter(values.values())))):
            numbers = [coefficients(section, PERIOD_S) for section in self.sections(values, i)]
            parts = (((c.b0 * z + c.b1) * z + c.b2) / ((z + c.a1) * z + c.a2) for c in numbers)
            rows.append(math.prod(parts, start=np.ones_like(z)))
        return np.array(rows)


def _path(values: Settings, prefix: str = "") -> np.ndarray:
    return np.array([values[f"{prefix}{key}"] for key in PATH])


def _cosh(values: Settings) -> Ends:
    x, small = values["alpha"] * values["e_max"], _path(values)
    steepest = np.cosh(x) + x * np.sinh(x)
    return small, np.concatenate([small[:3] * steepest, small[3:]])


PLAIN = {f"pid.{key}": ends for key, ends in PATH.items() if key != "filter_s"}
LOW_PASS = {"low_pass.corner_hz": (30.0, 900.0), "low_pass.damping": (0.3, 2.0)}
"""A low-pass may rise to 1.75 below its corner, no more: chosen, a resonance in a drive is no filter."""
LAG = {"lead_lag.zero_hz": (5.0, 500.0), "lead_lag.pole_hz": (1.0, 50.0)}
WIDER = {"pid.kp": (0.1, 40.0), "pid.kd": (5e-4, 0.5)}
"""Of a PID before a lag, which takes back the gain at high frequencies."""
INNER = "pid_low_pass."
"""Of ``pid_lag``, before the names of its PID and low-pass."""


def _plain(values: Settings, prefix: str = "pid.") -> Ends:
    kp, ki, kd = (values[f"{prefix}{key}"] for key in ("kp", "ki", "kd"))
    both = np.array([kp, ki, kd, np.zeros(len(kp))])
    return both, both


def _low_pass(values: Settings, i: int, prefix: str = "") -> LowPass:
    return LowPass(*(float(values[f"{prefix}low_pass.{key}"][i]) for key in LowPass._fields))


def _lag(values: Settings, i: int) -> tuple[LowPass, LeadLag]:
    lag = LeadLag(*(float(values[f"lead_lag.{key}"][i]) for key in LeadLag._fields))
    return _low_pass(values, i, INNER), lag


LAWS = {
    "pid": Law(table_pid, PATH, lambda values: (_path(values), _path(values))),
    "npid": Law(npid, PATH | {"alpha": (0.02, 5.0), "e_max": (0.1, 30.0)}, _cosh),
    "npid_split": Law(
        npid_split,
        {f"{path}.{key}": ends for path in ("quiet", "firm") for key, ends in PATH.items()} | {"es_um": (0.02, 10.0)},
        lambda values: (_path(values, "quiet."), _path(values, "firm.")),
    ),
    "pid_low_pass": Law(LINEAR["pid_low_pass"], PLAIN | LOW_PASS, _plain, lambda values, i: (_low_pass(values, i),)),
    "pid_lag": Law(
        LINEAR["pid_lag"],
        {f"{INNER}{key}": ends for key, ends in (PLAIN | LOW_PASS | WIDER).items()} | LAG,
        lambda values: _plain(values, f"{INNER}pid."),
        _lag,
    ),
}


# ---- bounds in closed form
@lru_cache(maxsize=1)
def responses() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """``z`` on a grid of frequencies, the nominal axis there, and those of the box, ``(12, frequencies)``."""
    one = table_pid(kp=1.0, ki=0.0, kd=0.0)
    w = np.unique(np.concatenate([np.geomspace(1.0, 1500.0, 200), np.linspace(200.0, np.pi / PERIOD_S, 500)]))
    plants = [dict(zip(BOX, map(float, values), strict=True)) for values in zip(*BOX.values(), strict=True)]
    box = np.array([opened(one, plant).response(w) for plant in plants])
    return np.exp(1j * w * PERIOD_S), opened(one).response(w), box


def of_gains(gains: np.ndarray, z: np.ndarray) -> np.ndarray:
    """``C(z)`` of parallel PIDs, ``(settings, frequencies)``; ``gains``: kp, ki, kd, filter_s by setting."""
    kp, ki, kd, lag = gains[:, :, None]
    return np.asarray(kp + ki * PERIOD_S * z / (z - 1.0) + kd * (z - 1.0) / ((lag + PERIOD_S) * z - lag))


@lru_cache(maxsize=1)
def box_finely() -> tuple[np.ndarray, np.ndarray]:
    """``z`` and the plants of the box on a grid of 1.5 rad/s, for peaks that a coarser one misses."""
    one = table_pid(kp=1.0, ki=0.0, kd=0.0)
    w = np.linspace(50.0, np.pi / PERIOD_S, 4000)
    plants = [dict(zip(BOX, map(float, values), strict=True)) for values in zip(*BOX.values(), strict=True)]
    return np.exp(1j * w * PERIOD_S), np.array([opened(one, plant).response(w) for plant in plants])


def worst_ms(law: Law, values: Settings) -> np.ndarray:
    """Largest Ms of the loops for small and for large errors over the plants of the box."""
    z, box = box_finely()
    loops = [of_gains(gains, z) * law.filters(values, z) for gains in law.ends(values)]
    peaks = [(1.0 / np.abs(1.0 + loop * table)).max(axis=1) for loop in loops for table in box]
    return np.asarray(np.max(peaks, axis=0))


def largest_ms(ends: Ends, filters: np.ndarray | float = 1.0) -> np.ndarray:
    """Ms over all ``s``: one over the distance of -1 from the straight line between both loops."""
    z, table, _ = responses()
    small, large = (of_gains(gains, z) * filters * table for gains in ends)
    back, way = 1.0 + small, large - small
    length = np.abs(way) ** 2
    s = np.clip(-(back * way.conj()).real / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    return np.asarray((1.0 / np.abs(back + s * way)).max(axis=1))


def unproved(ends: Ends, filters: np.ndarray | float = 1.0) -> np.ndarray:
    """What the box lacks, largest over its plants: not above 0 where every plant is stable under any ``s(t)``."""
    z, _, box = responses()
    small, large = (of_gains(gains, z) * filters for gains in ends)
    lacks = []
    for table in box:
        back = 1.0 + small * table
        turned = np.unwrap(np.angle(back), axis=1)[:, -1]
        circle = -ROOM * ((large - small) * table / back).real.min(axis=1) - 1.0
        lacks.append(np.where(np.abs(turned) < 0.5, circle, 10.0))
    return np.asarray(np.max(lacks, axis=0))


# ---- goal and activity by simulation
def rest_du_mv(
    lab: Lab, block: Block, settings: Settings | None = None, seconds: float = 4.0, offsets: int = 8
) -> np.ndarray:
    """Rms change of the output from sample to sample at rest, mV, behind the encoder of the study: one a setting.

    The table is asked to stand at ``offsets`` places within a count; the last three quarters count in mean square.
    """
    from leadscrew.kernel.metrics import chatter
    from leadscrew.references._step import step

    judged = {"chatter": chatter(from_time=0.25 * seconds)}
    loop = lab.loop(block, "quiet", reference=step(target=0.0), metrics=judged)
    changes = {f"controller.{key}": np.repeat(values, offsets) for key, values in (settings or {}).items()}
    count = len(next(iter(changes.values()))) // offsets if changes else 1
    changes["reference.target"] = np.tile(5e-4 * np.arange(offsets) / offsets, count)
    done = loop.batch(seconds, changes, record=())
    return np.asarray(1e3 * np.sqrt(np.mean(done.metrics["chatter"].reshape(-1, offsets) ** 2, axis=1)))


def at_work(
    lab: Lab, block: Block, settings: Settings, amplitude_mm: float, draws: int = DRAWS, seed: int = DRAW_SEED
) -> tuple[np.ndarray, np.ndarray]:
    """Mean row of Table II, um, and rms change of the output from sample to sample, mV: one a setting."""
    from leadscrew.kernel.metrics import chatter

    loop = lab.loop(block, "measured_1000", metrics={"chatter": chatter(from_time=0.5 * RUN_S)})
    count, rpm = len(next(iter(settings.values()))), np.repeat(SPEEDS, draws)
    cuts = line_volts(rpm, np.tile(phases_of(draws, seed), (len(SPEEDS), 1))) | {"plant.spindle_hz": rpm / 60.0}
    changes = {key: np.tile(values, count) for key, values in cuts.items()}
    changes |= {f"controller.{key}": np.repeat(values, len(rpm)) for key, values in settings.items()}
    done = loop.using({"reference.amplitude": amplitude_mm}).batch(RUN_S, changes, record="true_error", every=EVERY)
    rows = amplitudes_um(done).reshape(count, -1).mean(axis=1)
    return rows, 1e3 * np.sqrt(np.mean(done.metrics["chatter"].reshape(count, -1) ** 2, axis=1))


class Found(NamedTuple):
    """The best setting of a search, measured under draws that the search did not see."""

    law: str
    parameters: dict[str, float]
    row_um: float
    ms: float
    rest_mv: float
    work_mv: float
    holds: bool
    ends: tuple[str, ...]
    """Parameters within 1 % of an end of their range."""


def searched(
    lab: Lab, law: str, *, feed_forward: bool = False, rest_mv: float = np.inf, work_mv: float = np.inf,
    ms: float = MS, amplitude_mm: float = 1.0, budget: int = BUDGET, seed: int = SEED,
) -> Found:  # fmt: skip
    """The setting of a law with the smallest mean row under the bounds."""
    from leadscrew.tune.optimisers import Answer, Search, cma

    chosen = LAWS[law]
    plain, ranges, ends_of, _ = chosen
    block, prefix = (fed_forward(plain), "inner.") if feed_forward else (plain, "")
    low, high = np.log(np.array(list(ranges.values()))).T
    best, at = np.inf, np.full(len(ranges), 0.5)

    def settings_at(points: np.ndarray) -> dict[str, np.ndarray]:
        return dict(zip(ranges, np.exp(low + points * (high - low)).T, strict=True))

    def evaluate(points: np.ndarray) -> Answer:
        nonlocal best, at
        settings = settings_at(points)
        ends = ends_of(settings)
        filters = chosen.filters(settings, responses()[0])
        over = np.maximum(largest_ms(ends, filters) / ms - 1.0, 0.0) + np.maximum(unproved(ends, filters), 0.0)
        near = np.flatnonzero(over < NEAR)
        worth, lost = np.zeros(len(points)), np.where(over < NEAR, 0.0, over)
        if len(near):
            some = {key: values[near] for key, values in settings.items()}
            rows, work = at_work(lab, block, {f"{prefix}{key}": v for key, v in some.items()}, amplitude_mm)
            rest = rest_du_mv(lab, plain, some, 2.0) if np.isfinite(rest_mv) else np.zeros(len(near))
            missed = over[near] + np.maximum(rest / rest_mv / RESERVE - 1.0, 0.0)
            missed += np.maximum(work / work_mv / RESERVE - 1.0, 0.0)
            worth[near] = np.nan_to_num(np.log(rows) + STEEP * missed, nan=10.0, posinf=10.0)
            kept = np.where(missed > 0.0, np.inf, worth[near])
            if kept.min() < best:
                best, at = float(kept.min()), points[near[int(np.argmin(kept))]].copy()
        return Answer(worth[:, None], lost[:, None])

    with np.errstate(all="ignore"):
        cma(Search(evaluate, at, budget, seed, constraints=1))
    parameters = {key: float(f"{values[0]:.6g}") for key, values in settings_at(at[None]).items()}
    settings = {key: np.array([value]) for key, value in parameters.items()}
    inner = {f"{prefix}{key}": values for key, values in settings.items()}
    row, work = (float(x[0]) for x in at_work(lab, block, inner, amplitude_mm, HELD_OUT, 1))
    rest, ends = float(rest_du_mv(lab, plain, settings)[0]), ends_of(settings)
    filters = chosen.filters(settings, responses()[0])
    peak, proved = float(largest_ms(ends, filters)[0]), bool(unproved(ends, filters)[0] <= 0.0)
    holds = proved and peak <= 1.001 * ms and rest <= rest_mv and work <= work_mv
    at_end = tuple(key for key, x in zip(ranges, at, strict=True) if not 0.01 < x < 0.99)
    return Found(law, {key: float(v[0]) for key, v in inner.items()}, row, peak, rest, work, holds, at_end)
