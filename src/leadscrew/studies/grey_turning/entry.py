"""A tool that enters the cut at a constant feed, read at 10 kHz: the published cut at 0.416 mm/rev, simulated.

The carriage is at speed when the edge touches. Chip build-up alone takes one revolution, 0.056 s at 1080 1/min ("about
1080" in the facts: the revolution and the feed in mm/min are known no better than that); the published entry of 0.4 s
are 7.2 revolutions and 3 mm of feed. What made it so long is not published, so the depth is made to grow in one of two
ways: evenly from 0 (a chamfer of 3 mm), or at once to a share and evenly from there (a face that is nearly square). The
scatter is white noise of the reading beside the plant's runout: the reading alone, in the air, scatters by less than 1
N in the published record, so most of it comes from the cut and is not white there.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.analysis.cutting_force import PowerLaw
from leadscrew.kernel.block import controller
from leadscrew.kernel.sheet import Doc, Ge, Le, Unit
from leadscrew.plants.turning import turning
from leadscrew.references.cutting_program import cutting_force
from leadscrew.sensors.load_cell import lathe_reading
from leadscrew.studies.grey_turning.force_facts import ENTRY

PERIOD_S = 1e-4
LASTS_S = 1.6
SETTLED_S = 0.6
"""From here on the level and the scatter are taken."""
AT_ONCE = 0.79
"""Share of the depth that is in the cut at once, second way: in the published record some 570 of 723 N are reached
within 0.1 s, both 15 N above what the idle cell shows."""
PARTS = 100
"""Steps by which the depth grows in the second way."""
RUNOUT_MM = 0.01
TOUCH_N = 1.0
"""Force from which the tool counts as touching."""
CHIP_RPM = 1200.0
CHIP_FEED = 35.5
"""Spindle speed, 1/min, and feed, mm/min, of the paper's cut at 150 N."""


class SteadyFeedParams(NamedTuple):
    """The voltage."""

    voltage: Annotated[float, Unit("V"), Ge(0), Le(10), Doc("feed voltage, whatever the force")] = 1.0


@controller(SteadyFeedParams(), unit="V")
def steady_feed(p):
    """No control: a constant feed voltage."""
    return p.voltage


class Entered(NamedTuple):
    """Force against time."""

    time: np.ndarray
    raw: np.ndarray
    """What the load cell reads, N."""
    force: np.ndarray
    """Main cutting force, N."""
    level: float
    """Mean of the readings once settled, N."""
    scatter: float
    """Their standard deviation, N."""
    entry_s: float
    """From the first force until its mean over the last revolution stays within the published scatter of the level."""


class Entries(NamedTuple):
    """What was simulated."""

    even: Entered
    """The depth grows evenly in 0.4 s."""
    sudden: Entered
    """A share of it at once."""
    none: Entered
    """All of it at once: chip build-up alone."""
    chip_s: float
    """Time of the chip build-up at 1200 1/min and 35.5 mm/min, without compliance and runout, s."""
    seen_scatter: float
    """Scatter of the force that a control sees every 20 ms behind the filter of 0.8, N."""


def reading_noise(runout_mm: float = RUNOUT_MM) -> float:
    """Standard deviation of the reading that makes the published scatter together with the runout, N."""
    return float(np.sqrt(ENTRY.scatter_n**2 - (ENTRY.level_n * runout_mm) ** 2 / 2.0))


def entries(law: PowerLaw) -> Entries:
    """The four runs, with the exponent of a law; its ``Kf`` is taken from the published level."""
    from leadscrew.kernel.loop import Loop

    feed = ENTRY.feed * ENTRY.spindle_rpm
    kf = ENTRY.level_n / ENTRY.feed**law.exponent
    loop = Loop(
        reference=cutting_force(),
        controller=steady_feed(voltage=feed / 150.0),
        plant=turning(**{
            "law.kf": kf, "law.exponent": law.exponent, "spindle_rpm": ENTRY.spindle_rpm, "servo.rate": 5000.0,
            "servo.damping": 1.0, "servo.most": 1000.0, "runout": RUNOUT_MM, "feed_force_ratio": 0.5,
        }),
        sensor=lathe_reading(noise_n=reading_noise(), keep=0.0),
        period=PERIOD_S,
        substeps=1,
        metrics={},
        name="tool entry",
    )  # fmt: skip
    rest = 1.0 - AT_ONCE
    varied: dict[str, list[float]] = {
        "plant.depth.entry_s": [ENTRY.entry_s, 0.0, 0.0, 0.0],
        "plant.depth.start": [1.0, AT_ONCE, 1.0, 1.0],
        "plant.depth.step": [0.0, rest / PARTS, 0.0, 0.0],
        "plant.depth.every_s": [1.0, ENTRY.entry_s / PARTS, 1.0, 1.0],
        "plant.depth.steps": [0, PARTS, 0, 0],
        "plant.spindle_rpm": [*[ENTRY.spindle_rpm] * 3, CHIP_RPM],
        "controller.voltage": [*[feed / 150.0] * 3, CHIP_FEED / 150.0],
        "plant.runout": [*[RUNOUT_MM] * 3, 0.0],
        "plant.feed_force_ratio": [*[0.5] * 3, 1e-6],
        "plant.law.kf": [*[kf] * 3, 2256.3],
        "plant.law.exponent": [*[law.exponent] * 3, 0.77],
    }
    batch = loop.batch(LASTS_S, varied, record=("feedback.raw", "actual.force"))
    time = np.asarray(batch.time)
    found = [
        _entered(time, raw, force) for raw, force in zip(batch["feedback.raw"], batch["actual.force"], strict=True)
    ]
    last = batch["actual.force"][3]
    reached = time[int(np.argmax(last >= 0.999 * last[-1]))]
    even, sudden, none = found[:3]
    return Entries(even, sudden, none, float(reached), _seen(time, even.raw))


def _entered(time: np.ndarray, raw: np.ndarray, force: np.ndarray) -> Entered:
    settled = time >= SETTLED_S
    level = float(raw[settled].mean())
    turn = round(60.0 / ENTRY.spindle_rpm / PERIOD_S)
    sums = np.concatenate([[0.0], np.cumsum(force)])
    at = np.arange(1, len(force) + 1)
    first = np.maximum(at - turn, 0)
    mean = (sums[at] - sums[first]) / (at - first)
    away = np.flatnonzero(np.abs(mean - level) > ENTRY.scatter_n)
    touched = int(np.argmax(force > TOUCH_N))
    return Entered(time, raw, force, level, float(raw[settled].std()), float(time[away[-1]] - time[touched]))


def _seen(time: np.ndarray, raw: np.ndarray) -> float:
    from scipy.signal import lfilter

    taken = raw[time >= SETTLED_S - 0.3][:: round(0.02 / PERIOD_S)]
    passed = lfilter([0.2], [1.0, -0.8], taken - taken.mean())
    return float(passed[15:].std())
