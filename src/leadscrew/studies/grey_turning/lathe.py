"""The whole lathe: its three loops on one program, and the runs that claims and pictures need of it.

A TFC is a GPFC whose prediction is the last sample, so all of them are one program with other numbers; so is a constant
feed, a force controller whose two limits are one voltage.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.actuators.dac import lathe_dac
from leadscrew.controllers.grey_fuzzy.tunings import TUNINGS
from leadscrew.controllers.lathe_loops import lathe_loops
from leadscrew.kernel.block import Block
from leadscrew.plants.turning_lathe import turning_lathe
from leadscrew.references.lathe_program import lathe_program
from leadscrew.sensors.lathe_sensors import lathe_sensors
from leadscrew.studies.grey_turning.machines import PERIOD_S, SUBSTEPS

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

RPM, FORCE_N, GAIN = 1200.0, 150.0, 150.0
"""Speed, force, and feed in mm/min at 1 V, sections 5.1 and 5.2."""
HOLDING_V = 8.0
"""Spindle voltage of 1,200 1/min."""
LAST, READING_A = 0, 1
DIGEST_NOISE = {"sensor.rpm_noise": 5.0, "sensor.depth_noise_mm": 0.5e-3}
"""Scatter of speed and depth at which the digest's numbers of these two loops come out; the digest names none."""
SLOW_FEED = {"plant.servo.rate": 20.0, "plant.servo.dead_time_s": 0.02}
"""The feed servo of plant N."""
FALLING = {"reference.depth.step": -0.2, "reference.depth.steps": 3}
IDEAL = {f"actuator.{axis}.bits": 0 for axis in ("spindle", "feed", "radial")}
RECORD = ("actual", "feedback", "applied", "plant.peak", "plant.removed", "plant.over_s")
WAYS = {"tfc": (LAST, 0), "gpfc": (2, 0), "gpfc_a": (2, READING_A)}
"""Predictor and reading by law."""


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
        "actuator": lathe_dac(**{key.removeprefix("actuator."): bits for key, bits in IDEAL.items()}),
        "period": PERIOD_S,
        "substeps": SUBSTEPS,
        "metrics": {},
        "name": "the lathe under three loops",
    }
    return Loop(**(given | more))


def law(axis: str, name: str) -> dict[str, int]:
    """Changes that make one loop a ``tfc``, ``gpfc`` (reading B) or ``gpfc_a``."""
    predictor, reading = WAYS[name]
    return {f"controller.{axis}.predictor": predictor, f"controller.{axis}.reading": reading}


def force_law(tuning: str) -> dict[str, Any]:
    """Changes that put a TFC or GPFC of :data:`TUNINGS` on the feed."""
    params: Any = TUNINGS[tuning].params
    scales = {f"controller.feed.{key}": getattr(params, key) for key in ("error_scale", "change_scale", "output_scale")}
    predictor, reading = getattr(params, "predictor", LAST), getattr(params, "reading", 0)
    return scales | {"controller.feed.predictor": predictor, "controller.feed.reading": reading}


def constant_feed(feed: float) -> dict[str, float]:
    """Changes that hold the feed at so many mm/min: both limits of the voltage together."""
    return {"controller.feed.lower": feed / GAIN - 1e-9, "controller.feed.upper": feed / GAIN}


class Stair(NamedTuple):
    """What one step of the depth does to a signal, percent of the force to hold."""

    dip: float
    over: float


def stairs(t: np.ndarray, force: np.ndarray, count: int = 3, every_s: float = 2.0) -> list[Stair]:
    """Lowest and highest force in each interval behind a step; of rows, their mean."""
    found = []
    for k in range(1, count + 1):
        part = np.atleast_2d(force)[:, (t >= k * every_s - 1e-9) & (t < (k + 1) * every_s - 1e-9)] / FORCE_N - 1.0
        found.append(Stair(100.0 * float(part.min(axis=1).mean()), 100.0 * float(part.max(axis=1).mean())))
    return found


class LatheRuns:
    """Runs of the lathe, each made once."""

    def __init__(self) -> None:
        self.kept: dict[Any, Any] = {}

    @cached_property
    def running(self) -> Loop:
        """The spindle at 1,200 1/min, the tool at 1 mm in the cut, the feed at rest."""
        return self.ready(whole_lathe(three_loops()))

    @cached_property
    def standing(self) -> Loop:
        """Everything at rest, no force asked for."""
        controller = self.running.blocks["controller"]
        assert controller is not None
        plant = turning_lathe(**{"start.rpm": 0.0, "spindle.droop": 0.0})
        still = {"reference.force": 0.0, "sensor.cell.noise_n": 0.0}
        loop = whole_lathe(controller.starting(**{"spindle.output": 0.0}), plant=plant)
        return loop.using(still)

    @staticmethod
    def ready(loop: Loop) -> Loop:
        """The loop, its program made: those that follow from it by other values then share it."""
        loop.batch(PERIOD_S, {}, runs=1, record=RECORD)
        return loop

    def batch(self, loop: Loop, seconds: float, changes: Mapping[str, Any], runs: int = 1) -> Any:
        """A batch of ``runs`` with other noise; all signals kept."""
        key = (id(loop), seconds, tuple(sorted(changes.items())), runs)
        if key not in self.kept:
            self.kept[key] = loop.using(dict(changes)).batch(seconds, {}, runs=runs, record=RECORD)
        return self.kept[key]

    def spindle(self, name: str, noisy: bool = False, runs: int = 1) -> Any:
        """Run-up from rest to 1,200 1/min."""
        return self.batch(self.standing, 3.0, law("spindle", name) | (DIGEST_NOISE if noisy else {}), runs)

    def depth(self, name: str, noisy: bool = False, runs: int = 1) -> Any:
        """Cross slide from 1 to 0.8 mm, the step at the first sample."""
        changes = law("radial", name) | {"reference.depth.start": 0.8} | (DIGEST_NOISE if noisy else {})
        return self.batch(self.standing, 2.0, changes, runs)

    def staircase(self, tuning: str, steps: int = 3, runs: int = 1, droop: float = 2.5, noise_n: float = 2.0) -> Any:
        """All three loops, the depth falling by 0.2 mm every 2 s."""
        changes = force_law(tuning) | FALLING | {"reference.depth.steps": steps, "plant.spindle.droop": droop}
        return self.batch(self.running, 2.0 * (steps + 1), changes | {"sensor.cell.noise_n": noise_n}, runs)
