"""What only this study computes: the force law (1) at its units, the chip's build-up, and the rules as a surface.

Equation (1) is ``F = b Kf f^P``. With the printed parameters it gives forces of the paper's size only if ``f`` is the
feed per revolution. It holds once a whole revolution has been cut at one feed.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, NamedTuple

import numpy as np

from leadscrew.analysis.cutting_force import PowerLaw, feed_for
from leadscrew.controllers._grey_fuzzy.surface import concluded
from leadscrew.controllers._grey_fuzzy.tfc import tfc
from leadscrew.kernel.block import Block, controller
from leadscrew.kernel.parameters import Doc, Ge, Le, Unit
from leadscrew.plants._turning import turning
from leadscrew.plants._turning.chip import IRON, S45C
from leadscrew.references._cutting_program import cutting_force
from leadscrew.sensors._load_cell import lathe_reading
from leadscrew.studies.grey_turning.scenarios import FORCE_N, PERIOD_S, RPM
from leadscrew.studies.lab import Lab, measure

MATERIALS = {"S45C": PowerLaw(*S45C), "iron": PowerLaw(*IRON)}
FULL_FEED = 150.0
"""mm/min: the end of the feed's axis in Figure 6, and of the drive's range here."""


def feed_mm_min(material: str, depth: float) -> float:
    """The feed at which a cut of this depth takes 150 N at 1,200 1/min."""
    return float(RPM * feed_for(MATERIALS[material], FORCE_N, depth))


def force_at(material: str, feed: float, depth: float) -> float:
    """Force at a feed in mm/min and 1,200 1/min, N."""
    return float(MATERIALS[material].force(feed / RPM, depth))


class SteadyFeedParams(NamedTuple):
    """The voltage."""

    voltage: Annotated[float, Unit("V"), Ge(0), Le(10), Doc("feed voltage, whatever the force")] = 1.0


@controller(SteadyFeedParams(), unit="V")
def steady_feed(p):
    """No control: a constant feed voltage."""
    return p.voltage


CHIP_FEED = 35.5
"""mm/min: 150 N in S45C at 1 mm."""


@measure
def chip_build_up_s(lab: Lab) -> float:
    """From the first chip to 99.9 % of the steady force, on a rigid lathe at a constant feed; steps of 0.1 ms."""
    from leadscrew.kernel.loop import Loop

    loop = Loop(
        reference=cutting_force(),
        controller=steady_feed(voltage=CHIP_FEED / FULL_FEED),
        plant=turning.using(**{
            "servo.rate": 5000.0, "servo.damping": 1.0, "servo.max_feed": 1000.0, "runout": 0.0,
            "feed_force_ratio": 1e-6,
        }),
        sensor=lathe_reading(noise_n=0.0, keep=0.0),
        period=1e-4,
        substeps=1,
        metrics={},
    )  # fmt: skip
    run = loop.run(0.07, record=("actual.force",), engine="python")
    force = run["actual.force"]
    return float(run.time[int(np.argmax(force >= 0.999 * force[-1]))])


# ---- the rules as a surface
def answers(block: Block, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """What the rules say over S3 at errors of ``x`` S1 and changes of ``y`` S2: rows by x, columns by y."""
    p, b = block.prepare(block.params, PERIOD_S), block.params  # type: ignore[misc]
    return np.array([[concluded(p, b.error_scale * i, b.change_scale * j) for j in y] for i in x]) / b.output_scale


class Kinks(NamedTuple):
    """Of the surface within two factors of the set-point, where the standard table means a plane."""

    off: float
    """Distance from the plane, S3."""
    least: float
    """Least slope along the error; the plane has 1."""
    steepest: float


@measure
def kinks(lab: Lab, inference: Literal["product", "minimum"]) -> Kinks:
    """Of the standard table with the product or the minimum."""
    axis = np.linspace(-2.0, 2.0, 81)
    given = answers(tfc(inference=inference), axis, axis)
    slopes = np.diff(given, axis=0) / (axis[1] - axis[0])
    return Kinks(float(np.abs(given - axis[:, None] - axis[None, :]).max()), float(slopes.min()), float(slopes.max()))


# ---- the grey model on a sequence
def exponential(rate: float, count: int = 5) -> np.ndarray:
    """100 exp(-rate j)."""
    return 100.0 * np.exp(-rate * np.arange(count))


NEXT_N = 100.0 * math.exp(0.5)
"""The next sample after 100 exp(0.1 j), j = 0 ... 4."""
