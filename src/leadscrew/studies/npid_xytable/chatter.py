"""Chatter of the nonlinear PID: what it does at rest under a constant load, measured in batches, and predicted.

The load ``d`` is given by what the curve of the controller must carry, ``v = d / Kp`` in um: at rest ``phi(e) = v`` but
for the finite gain of the axis. Every run begins with a kick of 5 mV at 190 Hz that ends after 2 s; the last 0.5 s are
judged. The integral of Table I takes the load over with a time constant of 1600 s, which the predictions are told.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from leadscrew.controllers.npid import npid
from leadscrew.controllers.npid_after import npid_after
from leadscrew.controllers.npid_slope import npid_slope
from leadscrew.disturbances.kicked_load import kicked_load
from leadscrew.kernel.block import Block
from leadscrew.plants.xy_table import xy_table
from leadscrew.plants.xy_table_cutting import xy_table_cutting
from leadscrew.references.eased_sine import eased_sine
from leadscrew.studies.npid_xytable.calibration import BASE_HZ, DEAD_TIME_S, PERIOD_S
from leadscrew.studies.npid_xytable.chatter_theory import AXIS, GAINS, LIMIT_V, at_rest_um, load_of, slope
from leadscrew.studies.npid_xytable.runs import Loops

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

KICK_V = 5e-3
RUN_S = 4.0
JUDGED_S = 0.5
TAKEN_OVER = math.exp(-GAINS.ki / GAINS.kp * (RUN_S - 0.5 * JUDGED_S))
"""Share of the load that the curve still carries in the middle of what is judged; the integral has the rest."""

LOADS_UM = (2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 12.0, 15.0, 30.0)
"""The load table of the digest."""
RANGE_UM = tuple(np.arange(2.5, 13.6, 0.5).tolist())
"""Loads among which the largest chatter is looked for: those with which the digest's digits come out."""
DELAY_RANGE_UM = 11.5
"""The largest of them in the sweep of the dead time."""
E_MAX_UM = (1.88, 2.0, 2.5, 3.0, math.acosh(2.5) / 0.5)
"""Of the sweep; slopes 2.495, 2.718, 3.891, 5.546, 6.090."""
DELAYS_MS = (0.0, 0.1, 0.2, 0.5, 0.775)
LATE_S = DEAD_TIME_S + 0.075e-3
PERTURBED = {
    "gain": (1.2, DEAD_TIME_S, 1.0), "delay": (1.0, LATE_S, 1.0), "both": (1.2, LATE_S, 1.0), "box": (1.2, LATE_S, 0.8),
}  # fmt: skip
"""Factor of the plant's gain, dead time in s, factor of its damping; ``box`` is the worst corner of the box."""
CONTINUOUS_DEAD_TIME_S = 1.2888e-3
CONTINUOUS_STEPS = 50
"""Of the dead time of Lc: the loop is sampled that finely, hold and difference making up one of the steps."""
CONTINUOUS_LOADS_UM = (2.5, 2.7, 2.75, 2.8, 2.9)
SWEEP_S, SWEEP_UM = 90.0, (1.0, 19.0)
"""Time of a slow sweep one way, and its loads."""


class Chatter(NamedTuple):
    """Of each run of a batch."""

    mean_um: np.ndarray
    peak_to_peak_um: np.ndarray
    hz: np.ndarray
    """Strongest line, by a window over the last second; NaN where the run is quiet."""
    coarse_hz: np.ndarray
    """The same by a plain transform of what is judged, as the digest does: bins of 2 Hz."""


QUIET_UM = 0.01
"""Below this peak to peak a run is quiet: what is left is the drift of the integral."""


def chatter_loop(controller: Block, **options: Any) -> Loop:
    """A controller at rest (or on a sine, by ``reference.amplitude``) on the axis, under a load with a kick."""
    from leadscrew.kernel.loop import Loop

    given: dict[str, Any] = {
        "reference": eased_sine(amplitude=0.0, frequency=BASE_HZ),
        "controller": controller,
        "plant": xy_table_cutting,
        "disturbance": kicked_load(kick=KICK_V),
        "period": PERIOD_S,
        "metrics": {},
    }
    return Loop(**(given | options))


def volts(load_um: Any) -> np.ndarray:
    """The load in V for what the curve must carry, um."""
    return 1e-3 * GAINS.kp * np.asarray(load_um, dtype=float)


def judge(errors_um: np.ndarray, period: float) -> Chatter:
    """Mean, peak to peak and frequency of runs, one a row."""
    count = round(JUDGED_S / period)
    tail, longer = errors_um[:, -count:], errors_um[:, -2 * count :]
    size = np.ptp(tail, axis=1)
    hz = np.array([_line(x, period, True) for x in longer])
    coarse = np.array([_line(x, period, False) for x in tail])
    quiet = size < QUIET_UM
    return Chatter(np.abs(tail.mean(1)), size, np.where(quiet, np.nan, hz), np.where(quiet, np.nan, coarse))


def _line(x: np.ndarray, period: float, fine: bool) -> float:
    """Frequency of the strongest line, Hz."""
    x = x - x.mean()
    if not fine:
        return float(np.argmax(np.abs(np.fft.rfft(x))) / (len(x) * period))
    points = 16 * len(x)
    lines = np.log(np.abs(np.fft.rfft(x * np.hanning(len(x)), points)) + 1e-300)
    k = min(max(int(np.argmax(lines)), 1), len(lines) - 2)
    left, top, right = lines[k - 1 : k + 2]
    bent = left - 2.0 * top + right
    return float((k + (0.5 * (left - right) / bent if bent else 0.0)) / (points * period))


class Row(NamedTuple):
    """A run beside its predictions."""

    load_um: float
    e_max: float
    delay_s: float
    peak_to_peak_um: float
    hz: float


class Rows:
    """The experiments, each made once."""

    def measure(
        self, keys: Mapping[str, Any], controller: Block = npid, seconds: float = RUN_S, **options: Any
    ) -> Chatter:
        """A batch; keys by parameter, arrays one value a run."""
        loop = chatter_loop(controller, **options)
        count = max(len(np.atleast_1d(x)) for x in keys.values())
        arrays = {key: np.broadcast_to(np.asarray(x, dtype=float), count).copy() for key, x in keys.items()}
        done = loop.batch(seconds, arrays, record=("true_error",))
        return judge(1e3 * done["true_error"], loop.period or PERIOD_S)

    def under(self, loads_um: Sequence[float], controller: Block = npid, **more: Any) -> Chatter:
        """Runs under constant loads; ``more`` are parameters by key with ``__`` for the dot."""
        keys = {key.replace("__", "."): x for key, x in more.items()}
        return self.measure({"disturbance.size": volts(loads_um), **keys}, controller)

    @cached_property
    def table(self) -> Chatter:
        """The load table."""
        return self.under(LOADS_UM)

    @cached_property
    def by_e_max(self) -> list[Row]:
        """For each e_max the load of largest chatter."""
        return self._worst("controller.e_max", [(e, DEAD_TIME_S) for e in E_MAX_UM], E_MAX_UM, RANGE_UM)

    @cached_property
    def by_delay(self) -> list[Row]:
        """For each dead time the load of largest chatter."""
        seconds = [1e-3 * ms for ms in DELAYS_MS]
        loads = [v for v in RANGE_UM if v <= DELAY_RANGE_UM]
        return self._worst("plant.dead_time_s", [(3.0, d) for d in seconds], seconds, loads)

    def _worst(
        self, key: str, settings: Sequence[tuple[float, float]], values: Sequence[float], loads: Sequence[float]
    ) -> list[Row]:
        found = self.measure(
            {key: np.repeat(values, len(loads)), "disturbance.size": np.tile(volts(loads), len(values))}
        )
        size = found.peak_to_peak_um.reshape(len(values), -1)
        hz = found.hz.reshape(size.shape)
        worst = size.argmax(1)
        return [
            Row(loads[i], *setting, float(size[k, i]), float(hz[k, i]))
            for k, (i, setting) in enumerate(zip(worst.tolist(), settings, strict=True))
        ]

    @cached_property
    def rows(self) -> list[Row]:
        """Every row of the load table and of both sweeps in which there is a cycle."""
        table = [
            Row(v, 3.0, DEAD_TIME_S, float(p), float(f))
            for v, p, f in zip(LOADS_UM, self.table.peak_to_peak_um, self.table.hz, strict=True)
        ]
        return [r for r in (*table, *self.by_e_max, *self.by_delay) if r.peak_to_peak_um > QUIET_UM]

    @cached_property
    def threshold(self) -> tuple[float, float, float, float]:
        """Largest slope at rest that is quiet, smallest that chatters, and the errors there, um; 41 loads."""
        loads = np.array([load_of(e) for e in np.linspace(1.86, 1.92, 41)])
        found = self.measure({"disturbance.size": volts(loads), "controller.ki": 0.0}, seconds=12.0)
        rest = at_rest_um(loads)
        loud = found.peak_to_peak_um > QUIET_UM
        first = int(np.argmax(loud))
        quiet, noisy = rest[first - 1], rest[first]
        return float(slope(quiet)), float(slope(noisy)), float(quiet), float(noisy)

    @cached_property
    def sweep(self) -> tuple[np.ndarray, np.ndarray]:
        """Load in um, and peak to peak in um of each 0.1 s, up and down again, without the slow integral."""
        low, high = SWEEP_UM
        loop = chatter_loop(
            npid(ki=0.0),
            disturbance=kicked_load(
                size=float(volts(low)), rate=float(volts(high - low)) / SWEEP_S, turn_s=SWEEP_S, kick=0.0
            ),
        )
        run = loop.run(2.0 * SWEEP_S, record=("true_error",))
        parts = 1e3 * run["true_error"].reshape(-1, round(0.1 / PERIOD_S))
        t = 0.1 * (np.arange(len(parts)) + 0.5)
        # what the slow sweep itself moves in 0.1 s is no chatter
        straight = (
            parts - np.linspace(-0.5, 0.5, parts.shape[1]) * (parts[:, -20:].mean(1) - parts[:, :20].mean(1))[:, None]
        )
        return low + (high - low) * np.minimum(t, 2.0 * SWEEP_S - t) / SWEEP_S, np.ptp(straight, axis=1)

    @cached_property
    def edges(self) -> dict[str, float]:
        """Loads at which the slow sweep starts and stops to chatter: on the way up, on the way down."""
        loads, size = self.sweep
        half = len(loads) // 2
        loud = size > 0.1
        loud[:20] = False  # the load comes on as a step
        up, down = np.nonzero(loud[:half])[0], half + np.nonzero(loud[half:])[0]
        return {
            "up_starts": float(loads[up[0]]), "up_ends": float(loads[up[-1]]),
            "down_starts": float(loads[down[0]]), "down_ends": float(loads[down[-1]]),
        }  # fmt: skip

    @cached_property
    def kicks(self) -> dict[float, float]:
        """Peak to peak at a load of 12 um for kicks of several sizes, V."""
        sizes = (0.0, 1e-4, 1e-3, KICK_V, 2e-2)
        loads = volts(np.full(len(sizes), 12.0))
        found = self.measure({"disturbance.size": loads, "disturbance.kick": np.array(sizes)})
        return dict(zip(sizes, found.peak_to_peak_um.tolist(), strict=True))

    @cached_property
    def continuous(self) -> Chatter:
        """Lc under loads around its threshold."""
        period = CONTINUOUS_DEAD_TIME_S / CONTINUOUS_STEPS
        return self.measure(
            {"disturbance.size": volts(CONTINUOUS_LOADS_UM)}, seconds=round(6.0 / period) * period, plant=xy_table,
            period=period, computation_delay=(CONTINUOUS_STEPS - 1) * period,
        )  # fmt: skip

    @cached_property
    def slope_limited(self) -> Chatter:
        """The slope-limited law, k = 2.2 and es = 0.3 um, under loads of 1 to 30 um."""
        return self.under(np.arange(1.0, 30.5, 0.5).tolist(), npid_slope(k=2.2, es_um=0.3))

    @cached_property
    def behind(self) -> tuple[np.ndarray, Chatter]:
        """The gain behind the PID, under loads of 1 to 30 um."""
        loads = np.arange(1.0, 31.0)
        return loads, self.under(loads.tolist(), npid_after)

    @cached_property
    def perturbed(self) -> dict[str, tuple[float, float]]:
        """Error in um, rms, on a sine of 1 mm on a perturbed axis with 10 V of supply: NPID, and Table I's PID."""
        rows = [(*axis, alpha) for axis in PERTURBED.values() for alpha in (GAINS.alpha, 0.0)]
        gain, delay, damping, alpha = (np.array(x) for x in zip(*rows, strict=True))
        loop = chatter_loop(npid)
        keys = {
            "plant.gain": gain * AXIS.gain, "plant.dead_time_s": delay, "plant.damping": damping * AXIS.damping,
            "controller.alpha": alpha, "controller.max_output": np.full(len(rows), LIMIT_V),
            "reference.amplitude": np.ones(len(rows)),
        }  # fmt: skip
        errors = 1e3 * loop.batch(14.0, keys, record=("true_error",))["true_error"][:, round(4.0 / PERIOD_S) :]
        rms = np.sqrt(np.mean(errors**2, axis=1)).reshape(-1, 2)
        return {name: (float(a), float(b)) for name, (a, b) in zip(PERTURBED, rms.tolist(), strict=True)}


_kept: WeakKeyDictionary[Loops, Rows] = WeakKeyDictionary()


def rows_for(loops: Loops) -> Rows:
    """The experiments of these loops, kept with them."""
    if loops not in _kept:
        _kept[loops] = Rows()
    return _kept[loops]
