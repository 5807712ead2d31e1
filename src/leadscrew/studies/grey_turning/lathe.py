"""The whole lathe: spindle, feed and depth under three loops, all their variants on one program.

A TFC is a GPFC whose prediction is the last sample, so all of them are one program with other numbers; so is a constant
feed, a force controller whose two limits are one voltage.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.actuators._dac import lathe_dac
from leadscrew.controllers._lathe_loops import lathe_loops
from leadscrew.kernel.block import Block
from leadscrew.plants._turning_lathe import turning_lathe
from leadscrew.references._lathe_program import lathe_program
from leadscrew.sensors._lathe_sensors import lathe_sensors
from leadscrew.studies.grey_turning.cuts import PLANT_N
from leadscrew.studies.grey_turning.readings import read
from leadscrew.studies.grey_turning.scenarios import FORCE_N, PERIOD_S, RPM, SUBSTEPS
from leadscrew.studies.grey_turning.tunings import TUNINGS
from leadscrew.studies.lab import Lab, measure

if TYPE_CHECKING:
    from leadscrew.kernel.batch import Batch
    from leadscrew.kernel.loop import Loop

GAIN = 150.0
"""Feed in mm/min at 1 V."""
HOLDING_V = 8.0
"""Spindle voltage of 1,200 1/min."""
SEEDS = 20
FALLING = {"reference.depth.step": -0.2, "reference.depth.steps": 3}
AXES = ("spindle", "feed", "radial")
RECORD = ("actual", "feedback", "applied", "plant.peak", "plant.removed", "plant.over_s")
WAYS = {
    "tfc": ("last", "predicted_error"),
    "gpfc": ("gm11_clamped", "predicted_error"),
    "gpfc_a": ("gm11_clamped", "measured_error"),
}
"""Predictor and reading by law."""
TFC6, GPFC6, TFC9, GPFC9 = (f"corrected.{law}_{s}" for s in ("s6", "s9") for law in ("tfc", "gpfc_b"))


def three_loops(feed: Block = TUNINGS["corrected.gpfc_b_s9"]) -> Block:
    """The three loops, spindle and depth by the GPFC; the spindle's voltage at the start is that of 1,200 1/min."""
    spindle = TUNINGS["ours.spindle_gpfc"].starting(output=HOLDING_V)
    return lathe_loops(spindle, feed, TUNINGS["ours.depth_gpfc"], bumpless=False)


def whole_lathe(controller: Block, **more: Any) -> Loop:
    """The lathe under a controller of three voltages; ideal converters."""
    from leadscrew.kernel.loop import Loop

    given: dict[str, Any] = {
        "reference": lathe_program(rpm=RPM, force=FORCE_N),
        "controller": controller,
        "plant": turning_lathe,
        "sensor": lathe_sensors,
        "actuator": lathe_dac.using(**{f"{axis}.bits": 0 for axis in AXES}),
        "period": PERIOD_S,
        "substeps": SUBSTEPS,
        "metrics": {},
        "name": "the lathe under three loops",
    }
    return Loop(**(given | more))


def law(axis: str, name: str) -> dict[str, str]:
    """Changes that make one loop a ``tfc``, ``gpfc`` (reading B) or ``gpfc_a``."""
    predictor, reading = WAYS[name]
    return {f"controller.{axis}.predictor": predictor, f"controller.{axis}.reading": reading}


def force_law(tuning: str) -> dict[str, Any]:
    """Changes that put a TFC or GPFC of :data:`TUNINGS` on the feed."""
    params: Any = TUNINGS[tuning].params
    scales = {f"controller.feed.{key}": getattr(params, key) for key in ("error_scale", "change_scale", "output_scale")}
    predictor, reading = getattr(params, "predictor", 0), getattr(params, "reading", 0)
    return scales | {"controller.feed.predictor": predictor, "controller.feed.reading": reading}


def constant_feed(feed: float) -> dict[str, float]:
    """Changes that hold the feed at so many mm/min: both limits of the voltage together."""
    return {"controller.feed.lower": feed / GAIN - 1e-9, "controller.feed.upper": feed / GAIN}


@measure
def running(lab: Lab) -> Loop:
    """The spindle at 1,200 1/min, the tool at 1 mm in the cut, the feed at rest; its program made, to be shared."""
    loop = whole_lathe(three_loops())
    loop.batch(PERIOD_S, {}, runs=1, record=RECORD)
    return loop


def lathe_batch(lab: Lab, seconds: float, changes: Mapping[str, Any], runs: int = 1) -> Batch:
    """A batch of ``runs`` with other noise."""
    return running(lab).using(dict(changes)).batch(seconds, {}, runs=runs, record=RECORD)


@measure
def staircase(
    lab: Lab, tuning: str, steps: int = 3, runs: int = SEEDS, droop: float = 2.5, noise_n: float = 2.0
) -> Batch:
    """All three loops, the depth falling by 0.2 mm every 2 s."""
    changes = force_law(tuning) | FALLING | {"reference.depth.steps": steps, "plant.spindle.droop": droop}
    return lathe_batch(lab, 2.0 * (steps + 1), changes | {"sensor.cell.noise_n": noise_n}, runs)


@measure
def last_second(lab: Lab, tuning: str = GPFC9) -> tuple[float, float, float]:
    """Spindle speed, filtered force and depth in the last second of the falling depth, mean of the seeds."""
    run = staircase(lab, tuning)
    late = run.time > 7.0
    rpm, force, depth = (
        float(run[signal][:, late].mean()) for signal in ("actual.rpm", "feedback.force", "actual.depth")
    )
    return rpm, force, depth


# ---- converters
BITS = (0, 14, 12, 10, 8)
"""Bits over 20 V; 0: ideal."""


@measure
def converter_error(lab: Lab, tuning: str, bits: int, quiet: bool = False) -> float:
    """Steady error at 1 mm, % of 150 N; ``quiet``: without noise and runout."""
    changes = force_law(tuning) | {f"actuator.{axis}.bits": bits for axis in AXES}
    changes |= {"sensor.cell.noise_n": 0.0, "plant.runout": 0.0} if quiet else {}
    return float(read(lathe_batch(lab, 3.0, changes, 1 if quiet else SEEDS)["feedback.force"]).steady.mean())


# ---- other entries into the cut
ENTRIES = {"plunge": "plunge from 0 mm while the feed winds up", "air": "0.3 s of air before the full depth"}


@measure
def entry_overshoot(lab: Lab, tuning: str, how: str, seeds: int = 6) -> float:
    """Overshoot of the filtered force on plant N, percent."""
    changes = force_law(tuning) | PLANT_N
    if how == "plunge":
        changes |= {"plant.start.depth": 0.0}
    if how == "air":
        free = lathe_batch(lab, 0.5, changes | {"plant.work.starts": 1e6})
        changes |= {"plant.work.starts": float(np.interp(0.3, free.time, free["actual.travel"][0]))}
    return float(read(lathe_batch(lab, 3.0, changes, seeds)["feedback.force"]).overshoot.mean())
