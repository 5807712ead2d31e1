"""Two ways to learn: friction parameters on the way (``ours.pd_learned``), and a feed-forward from pass to pass.

On the way: true errors at 4 kHz with a scale of 10 nm. The controller believes the hats of Table 2 at its start and
learns in the first half of a run; the second half counts.

From pass to pass: a pass starts in steady sliding on the command, runs for :data:`SETTLE_S` and one period more, and is
judged over that period. Learned is the load of the disturbance observer, by
:func:`leadscrew.controllers._trial_learning.taught`: four samples ahead, smoothed over two, with a gain of 0.7.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.controllers._feed_forward_table import feed_forward_table
from leadscrew.controllers._trial_learning import last_period, taught
from leadscrew.friction.maxwell_slip import Elements, move_elements, stuck_stiffness
from leadscrew.plants._ballscrew_gms import ballscrew_gms, cut
from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.scenarios import ENCODER_NM, PERIOD_S, sine_of
from leadscrew.studies.lab import Lab, measure

if TYPE_CHECKING:
    from leadscrew.kernel.run import Run

OURS, BEFORE = "ours.pd_learned", "ours.pd_dob"
SECONDS = {"sine_slow": 8.4, "sine_wide": 12.0 * math.pi, "sine_fast": 12.0}
"""Four thirds of a period, six and twelve periods."""
TRUTHS: dict[str, dict[str, Any]] = {
    "Table 2": {},
    "friction +20 %": {"changes": {"plant.friction.coulomb": 1.2 * 6.24, "plant.friction.static": 1.2 * 9.36}},
    "friction −20 %": {"changes": {"plant.friction.coulomb": 0.8 * 6.24, "plant.friction.static": 0.8 * 9.36}},
}
"""What the stage is, and the options of its loops."""
MAXWELL: dict[str, Any] = {"machine": "gms", "changes": {"plant.longest_step": 4e-6}}
"""Six Maxwell elements in place of the bristles."""


# ---- on the way
def learned_run(lab: Lab, scenario: str, **options: Any) -> Run:
    """The run of the controller that learns; on the slow sine with looser tolerances, which its error does not show."""
    more = {"rtol": 1e-5, "atol": 1e-10} if scenario == "sine_slow" else {"encoder_nm": ENCODER_NM}
    return lab.run(OURS, scenario, SECONDS[scenario], **(more | options))


def half_period_s(scenario: str) -> float:
    """Time from one reversal to the next."""
    return math.pi / sine_of(scenario).rate_rad_s


def by_reversal_um(lab: Lab, scenario: str) -> np.ndarray:
    """Largest error around each reversal, from half way before to half way after it; not of the first 50 ms."""
    e, every = 1e3 * np.abs(learned_run(lab, scenario)["true_error"]), half_period_s(scenario) / PERIOD_S
    e[: int(0.05 / PERIOD_S)] = 0.0
    return np.array([e[int(k * every) : int((k + 1) * every)].max() for k in range(int(len(e) / every))])


class Slip(NamedTuple):
    """What comes of the last Maxwell element's slip when it is foreseen for another place."""

    travel: float
    """Travel since the reversal at which it slips, um."""
    one: float
    """Largest error one period later, um."""
    two: float
    """And two periods later."""


def slip_foreseen_wrong(wrong_nm: float, acceleration: float = 24.8, dt: float = 2e-6) -> Slip:
    """Drives the Maxwell stage with the exact torque of a motion ``a t^2 / 2`` after a reversal, through its last
    element's slip; but from 0.4 ms before that with the torque for a stage ``wrong_nm`` further or less far.

    The torque is worked out every 2 us from the plant's own step, so with 0 nm no error is made; no
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
    return Slip(
        1e3 * TRAVEL_MM_PER_RAD * bend, float(np.abs(error[: slips + period]).max()),
        float(np.abs(error[: slips + 2 * period]).max()),
    )  # fmt: skip


# ---- from pass to pass
FIXED, SCHEDULED = "ours.pd_dob_fixed", "ours.pd_dob"
"""Without and with gains that rise at low speed."""
SETTLE_S = 0.1
"""Seconds before the judged period: the start does not count, there the believed viscous friction is 3 N m too much."""
PASSES = 10


@measure
def passes_um(lab: Lab, base: str, scenario: str, count: int = PASSES, encoder_nm: float = ENCODER_NM) -> list[float]:
    """Largest true error over a period, in um, after 0, 1, ... ``count`` passes of learning."""
    period = 2.0 * half_period_s(scenario)
    size = round(period / PERIOD_S)
    block, table, errors = feed_forward_table(CONTROLLERS[FIXED], np.zeros(size)), np.zeros(size), []
    assert block.params is not None
    loop = lab.loop(
        replace(block, params=block.params._replace(inner=CONTROLLERS[base].params, period_s=period)),
        scenario, encoder_nm=encoder_nm, rtol=1e-3, atol=1e-8,
    )  # fmt: skip
    for _ in range(count + 1):
        run = loop.using({"controller.table": table}).run(
            SETTLE_S + period, record=("true_error", "controller.inner.load")
        )
        errors.append(1e3 * float(np.abs(last_period(run.time, run["true_error"], period, size)).max()))
        table = taught(table, last_period(run.time, run["controller.inner.load"], period, size))
    return errors
