"""Chatter of the nonlinear PID: what it does at rest under a constant load, measured in batches, and predicted.

The load ``d`` is given by what the curve of the controller must carry, ``v = d / Kp`` in um: at rest ``phi(e) = v`` but
for the finite gain of the axis. Every run begins with a kick of 5 mV at 190 Hz that ends after 2 s; the last 0.5 s are
judged. The integral of Table I takes the load over with a time constant of 1600 s, which the predictions allow for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.disturbances._kicked_load import kicked_load
from leadscrew.kernel.block import Block
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.npid_xytable.calibration import DEAD_TIME_S, PERIOD_S
from leadscrew.studies.npid_xytable.cutting import load_volts
from leadscrew.studies.npid_xytable.laws import GAINS, STATIC_GAIN, curve
from leadscrew.studies.npid_xytable.tunings import table_pid

if TYPE_CHECKING:
    from leadscrew.analysis.stability.harmonic_balance import CyclePrediction
    from leadscrew.analysis.stability.linear import LinearLoop
    from leadscrew.kernel.loop import Loop

NPID = "corrected.npid_um"
KICK_V = 5e-3
RUN_S, JUDGED_S = 4.0, 0.5
TAKEN_OVER = math.exp(-GAINS.ki / GAINS.kp * (RUN_S - 0.5 * JUDGED_S))
"""Share of the load that the curve still carries in the middle of what is judged; the integral has the rest."""
LOADS_UM = (2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 12.0, 15.0, 30.0)
RANGE_UM = tuple(np.arange(2.5, 13.6, 0.5).tolist())
"""Loads among which the largest chatter is looked for."""
DELAY_RANGE_UM = 11.5
"""The largest of them in the sweep of the dead time."""
E_MAX_UM = (1.88, 2.0, 2.5, 3.0, math.acosh(2.5) / 0.5)
"""Of the sweep; slopes 2.495, 2.718, 3.891, 5.546, 6.090."""
DELAYS_MS = (0.0, 0.1, 0.2, 0.5, 0.775)
SWEEP_S, SWEEP_UM = 90.0, (1.0, 19.0)
"""Time of a slow sweep one way, and its loads."""
QUIET_UM = 0.01
"""Below this peak to peak a run is quiet: what is left is the drift of the integral."""


class Chatter(NamedTuple):
    """Of each run of a batch."""

    mean_um: np.ndarray
    peak_to_peak_um: np.ndarray
    hz: np.ndarray
    """Strongest line, by a window over the last second; NaN where the run is quiet."""


class Row(NamedTuple):
    """A run beside the setting that its prediction needs."""

    load_um: float
    e_max: float
    delay_s: float
    mean_um: float
    peak_to_peak_um: float
    hz: float


def chatter_loop(lab: Lab, controller: str | Block = NPID, **load: Any) -> Loop:
    """A controller at rest on L*, under a load with a kick."""
    return lab.loop(controller, "constant_load", disturbance=kicked_load(**({"kick": KICK_V} | load)))


def measured(
    lab: Lab, keys: Mapping[str, Any], controller: str | Block = NPID, seconds: float = RUN_S, **load: float
) -> Chatter:
    """A batch; keys by parameter, arrays one value a run."""
    count = max(len(np.atleast_1d(x)) for x in keys.values())
    arrays = {key: np.broadcast_to(np.asarray(x, dtype=float), count).copy() for key, x in keys.items()}
    done = chatter_loop(lab, controller, **load).batch(seconds, arrays, record=("true_error",))
    return judge(1e3 * done["true_error"], PERIOD_S)


def judge(errors_um: np.ndarray, period: float) -> Chatter:
    """Mean, peak to peak and frequency of runs, one a row."""
    count = round(JUDGED_S / period)
    tail, longer = errors_um[:, -count:], errors_um[:, -2 * count :]
    size = np.ptp(tail, axis=1)
    hz = np.array([strongest_hz(x, period) for x in longer])
    return Chatter(np.abs(tail.mean(1)), size, np.where(size < QUIET_UM, np.nan, hz))


def strongest_hz(x: np.ndarray, period: float) -> float:
    """Frequency of the strongest line: a parabola through the logarithm of a Hann-windowed spectrum."""
    x = x - x.mean()
    points = 16 * len(x)
    lines = np.log(np.abs(np.fft.rfft(x * np.hanning(len(x)), points)) + 1e-300)
    k = min(max(int(np.argmax(lines)), 1), len(lines) - 2)
    left, top, right = lines[k - 1 : k + 2]
    bent = left - 2.0 * top + right
    return float((k + (0.5 * (left - right) / bent if bent else 0.0)) / (points * period))


@measure
def by_load(lab: Lab) -> list[Row]:
    """NPID in L* under :data:`LOADS_UM`."""
    found = measured(lab, {"disturbance.size": load_volts(LOADS_UM)})
    return [
        Row(v, GAINS.e_max, DEAD_TIME_S, *map(float, one))
        for v, *one in zip(LOADS_UM, found.mean_um, found.peak_to_peak_um, found.hz, strict=True)
    ]


@measure
def by_e_max(lab: Lab) -> list[Row]:
    """For each e_max the load of largest chatter."""
    return _largest(lab, "controller.e_max", [(e, DEAD_TIME_S) for e in E_MAX_UM], E_MAX_UM, RANGE_UM)


@measure
def by_delay(lab: Lab) -> list[Row]:
    """For each dead time the load of largest chatter."""
    seconds, loads = [1e-3 * ms for ms in DELAYS_MS], [v for v in RANGE_UM if v <= DELAY_RANGE_UM]
    return _largest(lab, "plant.dead_time_s", [(GAINS.e_max, d) for d in seconds], seconds, loads)


def _largest(
    lab: Lab, key: str, settings: Sequence[tuple[float, float]], values: Sequence[float], loads: Sequence[float]
) -> list[Row]:
    keys = {key: np.repeat(values, len(loads)), "disturbance.size": np.tile(load_volts(loads), len(values))}
    mean, size, hz = (x.reshape(len(values), -1) for x in measured(lab, keys))
    return [
        Row(loads[i], *setting, float(mean[k, i]), float(size[k, i]), float(hz[k, i]))
        for k, (i, setting) in enumerate(zip(size.argmax(1).tolist(), settings, strict=True))
    ]


@measure
def kicked_um(lab: Lab) -> dict[float, float]:
    """Peak to peak at a load of 12 um, by the size of the kick, V."""
    sizes = (0.0, 1e-4, 1e-3, KICK_V)
    keys = {"disturbance.size": load_volts(np.full(len(sizes), 12.0)), "disturbance.kick": np.array(sizes)}
    return dict(zip(sizes, measured(lab, keys).peak_to_peak_um.tolist(), strict=True))


@measure
def slow_sweep(lab: Lab) -> tuple[np.ndarray, np.ndarray]:
    """Load in um, and peak to peak in um of each 0.1 s, up and down again, without the slow integral."""
    low, high = SWEEP_UM
    size, rate = float(load_volts(low)), float(load_volts(high - low)) / SWEEP_S
    loop = chatter_loop(lab, NPID, size=size, rate=rate, turn_s=SWEEP_S, kick=0.0)
    run = loop.using({"controller.ki": 0.0}).run(2.0 * SWEEP_S, record=("true_error",))
    parts = 1e3 * run["true_error"].reshape(-1, round(0.1 / PERIOD_S))
    t = 0.1 * (np.arange(len(parts)) + 0.5)
    # What the slow sweep itself moves in 0.1 s is no chatter.
    drift = (parts[:, -20:].mean(1) - parts[:, :20].mean(1))[:, None]
    straight = parts - np.linspace(-0.5, 0.5, parts.shape[1]) * drift
    return low + (high - low) * np.minimum(t, 2.0 * SWEEP_S - t) / SWEEP_S, np.ptp(straight, axis=1)


@measure
def edges_um(lab: Lab) -> dict[str, float]:
    """Loads at which the slow sweep starts and stops to chatter: on the way up, on the way down."""
    loads, size = slow_sweep(lab)
    half = len(loads) // 2
    loud = size > 0.1
    loud[:20] = False  # the load comes on as a step
    up, down = np.nonzero(loud[:half])[0], half + np.nonzero(loud[half:])[0]
    return {
        "up_starts": float(loads[up[0]]),
        "up_ends": float(loads[up[-1]]),
        "down_starts": float(loads[down[0]]),
        "down_ends": float(loads[down[-1]]),
    }


# ---- predicted
@measure
def linear(lab: Lab, delay_s: float = DEAD_TIME_S) -> LinearLoop:
    """The loop of Table I's PID without its slow integral, at this dead time."""
    from leadscrew.analysis.stability.loop import sampled_loop

    loop = lab.loop(table_pid(ki=0.0), "sine_1mm").using({"plant.dead_time_s": delay_s})
    return sampled_loop(loop, f"L, {1e3 * delay_s:g} ms")


@measure
def predicted(lab: Lab, load_um: float, e_max: float, delay_s: float, many: bool) -> CyclePrediction:
    """Limit cycles under a load: by harmonic balance, or by the describing function alone (``many`` false)."""
    from leadscrew.analysis.stability.harmonic_balance import limit_cycles

    return limit_cycles(
        linear(lab, delay_s),
        lambda e: curve(e, e_max),
        1e-3 * load_um,
        harmonics=30 if many else 1,
        static_gain=STATIC_GAIN,
        amplitudes=(1e-5, 0.1),
    )


def predicted_um(lab: Lab, row: Row, many: bool) -> float:
    """Predicted peak to peak of a row; 0 where no cycle is predicted."""
    from leadscrew.analysis.stability.harmonic_balance import biggest

    cycle = biggest(predicted(lab, row.load_um * TAKEN_OVER, row.e_max, row.delay_s, many))
    return 0.0 if cycle is None else 1e3 * float(cycle.peak_to_peak)
