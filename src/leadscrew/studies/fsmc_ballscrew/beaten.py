"""Runs of the controller that learns its friction, and why half an encoder step is too much on Maxwell elements."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.controllers.pd_dob import TUNINGS as PD_DOB
from leadscrew.controllers.pd_learned import TUNINGS as LEARNED
from leadscrew.friction.maxwell_slip import Elements, move_elements, stuck_stiffness
from leadscrew.kernel.block import reference
from leadscrew.plants.ballscrew_gms import ballscrew_gms, cut, sliding_at
from leadscrew.plants.ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.references.motion import Motion
from leadscrew.sensors.ruler import ruler
from leadscrew.studies.fsmc_ballscrew.circles import CIRCLES, drawn
from leadscrew.studies.fsmc_ballscrew.runs import ENCODER_NM, PERIOD_S, Loops
from leadscrew.studies.fsmc_ballscrew.scenarios import SCENARIOS, SINES, SineMove, command, start_speed

if TYPE_CHECKING:
    from leadscrew.analysis.circular.paths import CircularTest
    from leadscrew.kernel.block import Block
    from leadscrew.kernel.loop import Loop

OURS = LEARNED["ours.pd_learned"](travel_per_rad=TRAVEL_MM_PER_RAD)
BEFORE = PD_DOB["ours.pd_dob"](travel_per_rad=TRAVEL_MM_PER_RAD)

SECONDS = {"sine_slow": 8.4, "sine_wide": 12.0 * math.pi, "sine_fast": 12.0}
"""Four thirds of a period, six and twelve periods; the second half counts. In the first half it learns."""

REVERSALS = {"sine_slow": math.pi, "sine_wide": math.pi, "sine_fast": 0.5}
"""Time between two, in s."""


MAXWELL_SECONDS = {"sine_slow": 2.0 * math.pi, "sine_wide": 4.0 * math.pi, "sine_fast": 6.0}
"""The same under Maxwell slip."""

LOOSE = {"rtol": 1e-5, "atol": 1e-10}
"""Tolerances of the slow sine, where the stage sticks and slips: largest and RMS errors stand still from here on."""

SETTLED = 0.05
"""Of a sine that starts in motion the first 50 ms do not count as a reversal: there the believed viscous friction is
2.5 to 3.2 N m too much at once."""


class WanderParams(NamedTuple):
    """Three sines whose frequencies have no common measure."""

    size: float = 1.0


@reference(WanderParams(), unit="mm")
def wander(p, t):
    """A smooth path that never repeats: 2 sin 2.3 t + sin 3.7 sqrt(2) t + 0.5 sin 4.1 sqrt(5) t mm, up to 20 mm/s."""
    a = 2.3
    b = 3.7 * math.sqrt(2.0)
    c = 4.1 * math.sqrt(5.0)
    x = 2.0 * math.sin(a * t) + math.sin(b * t) + 0.5 * math.sin(c * t)
    v = 2.0 * a * math.cos(a * t) + b * math.cos(b * t) + 0.5 * c * math.cos(c * t)
    f = -2.0 * a * a * math.sin(a * t) - b * b * math.sin(b * t) - 0.5 * c * c * math.sin(c * t)
    return Motion(p.size * x, p.size * v, p.size * f)


class Runs:
    """The runs of the claims, each made once. Errors in um."""

    def __init__(self, loops: Loops) -> None:
        self.loops = loops
        self._kept: dict[Any, Any] = {}

    def error(self, block: Block, scenario: str, seconds: float | None = None, **options: Any) -> Any:
        """True error over time in um, on LuGre's stage; infinite where it diverges."""
        key = (block.name, scenario, seconds, repr(sorted(options.items())))
        if key not in self._kept:
            given = LOOSE | options if scenario == "sine_slow" else options
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)
                run = self.loops.get(block, scenario, **given).run(seconds or SECONDS[scenario], record="true_error")
            self._kept[key] = np.full(2, math.inf) if run.diverged else 1e3 * run["true_error"]
        return self._kept[key]

    def late(self, block: Block, scenario: str, **options: Any) -> float:
        """Largest error in the second half, um."""
        e = self.error(block, scenario, **options)
        return float(np.abs(e[len(e) // 2 :]).max())

    def by_reversal(self, block: Block, scenario: str, **options: Any) -> Any:
        """Largest error around each reversal, from half way before to half way after it; not of the start."""
        e, every = np.abs(self.error(block, scenario, **options)), REVERSALS[scenario] / PERIOD_S
        e[: int(SETTLED / PERIOD_S)] = 0.0
        last = int(len(e) / every)
        return np.array([e[int(k * every) : int((k + 1) * every)].max() for k in range(last)])

    def scatter(self, block: Block, scenario: str, changes: Mapping[str, float]) -> Any:
        """Largest error in um around each late reversal of a sine, for eight amplitudes within 2 %, sorted."""
        loop = self.loops.get(block, scenario, changes=changes)
        size = loop.parameters["reference.amplitude"]
        varied = {"reference.amplitude": size * (1.0 + 0.02 * np.linspace(-1.0, 1.0, 8))}
        found = loop.batch(16.0 * REVERSALS[scenario], varied, record="true_error")["true_error"]
        every = int(REVERSALS[scenario] / PERIOD_S)
        e = 1e3 * np.abs(np.asarray(found))[:, 8 * every : 16 * every]
        return np.sort(e.reshape(8, 8, every).max(axis=2).ravel())

    def on_maxwell(self, block: Block, scenario: str) -> float:
        """Largest error in the second half, um, with six Maxwell elements for friction."""
        key = (block.name, scenario, "maxwell")
        if key not in self._kept:
            e = (
                1e3
                * maxwell_loop(self.loops, block, scenario).run(SECONDS[scenario], record="true_error")["true_error"]
            )
            self._kept[key] = float(np.abs(e[len(e) // 2 :]).max())
        return float(self._kept[key])

    def wandering(self, block: Block, seconds: float = 40.0) -> tuple[float, float]:
        """Largest and RMS error in um of the second half of a path that never repeats."""
        key = (block.name, "wander", seconds)
        if key not in self._kept:
            loop = self.loops.get(block, "sine_fast")
            e = 1e3 * _on(loop, wander).run(seconds, record="true_error")["true_error"]
            e = e[len(e) // 2 :]
            self._kept[key] = float(np.abs(e).max()), math.sqrt(float(np.mean(e * e)))
        return self._kept[key]

    def circle(self, block: Block, turns: float) -> CircularTest:
        """R = 100 mm at 1,000 mm/min in both directions; the last turn."""
        key = (block.name, "circle", turns)
        if key not in self._kept:
            self._kept[key] = drawn(self.loops, block, CIRCLES["r100"], both=True, turns=turns)
        return self._kept[key]


def _on(loop: Loop, path: Block) -> Loop:
    """The same loop on another path, from rest."""
    from leadscrew.kernel.loop import Loop as Built

    blocks = loop.blocks
    plant, law = blocks["plant"], blocks["controller"]
    assert plant is not None and law is not None
    return Built(
        reference=path, controller=law, plant=plant.starting(speed=0.0, bristle=0.0),
        sensor=blocks["sensor"], period=PERIOD_S, metrics={}, method="rodas", rtol=1e-6, atol=1e-12,
    )  # fmt: skip


def maxwell_loop(loops: Loops, block: Block, scenario: str) -> Loop:
    """A sine on the stage with Maxwell slip, in steady sliding at the start."""
    from leadscrew.kernel.loop import Loop as Built

    asked = SCENARIOS[scenario]
    assert isinstance(asked.params, SineMove)
    plant = sliding_at(ballscrew_gms(travel_per_rad=TRAVEL_MM_PER_RAD, longest_step=4e-6), start_speed(asked.params))
    return (
        Built(
            reference=command(asked.params), controller=block, plant=plant, period=PERIOD_S, metrics={},
            sensor=ruler(resolution_mm=1e-6 * ENCODER_NM),
        )
    )  # fmt: skip


def friction(by: float) -> Mapping[str, float]:
    """Changes of the stage's Coulomb and static friction."""
    return {"plant.friction.coulomb": by * 6.24, "plant.friction.static": by * 9.36}


class Slip(NamedTuple):
    """What comes of the last Maxwell element's slip when it is foreseen for another place."""

    travel: float
    """Travel since the reversal at which it slips, um."""
    drop: float
    """Damping torque that goes with it, N m."""
    one: float
    """Largest error one period later, um."""
    two: float
    """And two periods later."""


def slip_foreseen_wrong(wrong_nm: float, acceleration: float = 24.8, dt: float = 2e-6) -> Slip:
    """Drives the Maxwell stage with the exact torque of a motion ``a t^2 / 2`` after a reversal, through its last
    element's slip; but from 0.4 ms before that with the torque for a stage ``wrong_nm`` further or less far.

    The torque is worked out every 2 us from the plant's own step, so with 0 nm nothing is lost; no
    controller, no encoder, no sampling takes part. What is left is what a wrong position alone does before anybody can
    see it: at 4 kHz one period passes before it is measured and half of the next before a torque acts.
    """
    p = cut(ballscrew_gms.params, dt)
    f = p.friction
    share, stiff = np.asarray(f.share), np.asarray(f.stiffness)
    bend = 2.0 * float((share / stiff)[-1]) * f.coulomb
    after = math.sqrt(2.0 * bend / acceleration)
    before = 6e-4
    start = after - before
    steps = int((before + 2.5 * PERIOD_S) / dt)

    def near() -> Elements:
        last = -share[-1] * f.coulomb + stiff[-1] * 0.5 * acceleration * start**2
        return Elements(np.append(share[:-1] * f.coulomb, last), np.append(np.ones(len(share) - 1), 0.0))

    def damping(e: Elements) -> float:
        return f.damping * stuck_stiffness(f, e) / p.stiffness + f.viscous

    torque, elements, v = np.empty(steps), near(), acceleration * start
    for k in range(steps):
        stuck, ahead = stuck_stiffness(f, elements), acceleration * (start + (k + 1) * dt)
        held = (p.inertia + dt * damping(elements) + dt * dt * stuck) * ahead - p.inertia * v
        torque[k] = held / dt + elements.force.sum()
        v, elements = ahead, move_elements(f, elements, ahead, dt)
    slips = int(before / dt)
    shift = round(wrong_nm * 1e-6 / TRAVEL_MM_PER_RAD / (acceleration * after) / dt)
    driven = torque.copy()
    first = slips - int(4e-4 / dt)
    driven[first:] = np.roll(torque, shift)[first:]
    elements, v, x = near(), acceleration * start, 0.0
    error = np.empty(steps)
    for k in range(steps):
        stuck = stuck_stiffness(f, elements)
        pushed = p.inertia * v + dt * (driven[k] - elements.force.sum())
        v = pushed / (p.inertia + dt * damping(elements) + dt * dt * stuck)
        elements = move_elements(f, elements, v, dt)
        x += dt * v
        t = (k + 1) * dt
        error[k] = 1e3 * TRAVEL_MM_PER_RAD * (x - start * acceleration * t - 0.5 * acceleration * t * t)
    period = int(PERIOD_S / dt)
    drop = float(f.damping * stiff[-1] / p.stiffness * acceleration * after)
    return Slip(
        1e3 * TRAVEL_MM_PER_RAD * bend, drop, float(np.abs(error[: slips + period]).max()),
        float(np.abs(error[: slips + 2 * period]).max()),
    )  # fmt: skip


__all__ = [
    "BEFORE", "OURS", "REVERSALS", "SECONDS", "SINES", "Runs", "Slip", "friction", "maxwell_loop",
    "slip_foreseen_wrong", "wander",
]  # fmt: skip
