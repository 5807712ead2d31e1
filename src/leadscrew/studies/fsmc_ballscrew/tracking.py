"""Runs of the five laws in continuous time, and what is read from them: errors, torque, what a reversal leaves."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from leadscrew.friction.lugre import LuGre
from leadscrew.studies.fsmc_ballscrew.runs import SIGNALS, Loops
from leadscrew.studies.fsmc_ballscrew.scenarios import SCENARIOS, SineMove

LAWS = ("corrected.smc", "paper.smc", "paper.csmc", "corrected.fsmc", "paper.fsmc")
"""In continuous time, with the printed gains."""

SECONDS = {"sine_slow": 8.4, "sine_wide": 8.4, "sine_fast": 3.0}
"""How long a sine runs."""

WINDOW = {"sine_slow": (3.0, 8.4), "sine_wide": (3.0, 8.4), "sine_fast": (1.0, 3.0)}
"""What counts of it, in seconds: two reversals of the slow sines, four of the fast one.

RMS values and variation per second of the slow sines depend on the window. The digest does not name its own; this one
gives its ten RMS values within 2 %, a whole period gives 0.97 to 1.03 of the smooth ones and 0.91 to 0.96 of the peaked
ones.
"""

SAMPLES = {"sine_fast": 5e-5}
"""Interval between samples where the default is too coarse for the peak after a reversal, in seconds."""


class Tracked(NamedTuple):
    """A sine, in what counts of it."""

    largest: float
    """Largest true error, um."""
    rms: float
    """Root mean square of the true error, um."""
    torque: float
    """Largest torque, N m."""
    variation: float
    """Total variation of the torque per second, N m/s."""


RECORD = (*SIGNALS, "actual.velocity", "command.velocity")


def sine_run(loops: Loops, law: str, scenario: str, **options: Any) -> Any:
    """The run of a law on a sine."""
    more = {"sample": SAMPLES[scenario]} | options if scenario in SAMPLES else options
    return loops.run(law, scenario, SECONDS[scenario], record=RECORD, **more)


def tracked(run: Any, scenario: str) -> Tracked:
    """What is read from the run of a sine; NaN after a divergence."""
    first, last = WINDOW[scenario]
    t = run["time"]
    inside = (t >= first) & (t <= last)
    if run.diverged or not inside.any():
        return Tracked(math.nan, math.nan, math.nan, math.nan)
    e, torque = 1e3 * run["true_error"][inside], run["output"][inside]
    variation = np.abs(np.diff(torque)).sum() / (t[inside][-1] - t[inside][0])
    return Tracked(
        float(np.abs(e).max()), math.sqrt(float(np.mean(e * e))), float(np.abs(torque).max()), float(variation)
    )


class Reversal(NamedTuple):
    """What the error does after the axis turns round, positive towards its peak."""

    peak: float
    """Largest error, nm."""
    after: float
    """Error of steady sliding that follows, nm: the mean from a twentieth to a tenth of a period later."""
    first: float
    """Time from the reversal until the error is first back within a tenth of the peak of ``after``, s."""
    settled: float
    """The same until it stays there, s."""
    swing: float
    """How far it swings past ``after`` in between, as a part of the peak."""


def moving(scenario: str) -> SineMove:
    """The sine of a scenario."""
    params = SCENARIOS[scenario].params
    assert isinstance(params, SineMove)
    return params


def reversal_time(scenario: str) -> float:
    """Instant of a reversal of a sine that lies inside :data:`WINDOW` with its neighbourhood, s."""
    rate = moving(scenario).rate_rad_s
    return (1.5 if rate < 2.0 else 5.5) * math.pi / rate


def reversal(run: Any, scenario: str) -> Reversal:
    """The reversal of :func:`reversal_time`, looked at for a tenth of a period."""
    at, period = reversal_time(scenario), 2.0 * math.pi / moving(scenario).rate_rad_s
    t = run["time"]
    inside = (t >= at) & (t <= at + 0.1 * period)
    since, error = t[inside] - at, 1e6 * run["true_error"][inside]
    top = int(np.abs(error).argmax())
    error = math.copysign(1.0, error[top]) * error
    peak, after = float(error[top]), float(np.mean(error[since >= 0.05 * period]))
    away = np.abs(error - after) > 0.1 * peak
    first = since[np.flatnonzero(~away & (since > since[top]))[0]]
    settled = since[np.flatnonzero(away)[-1]]
    return Reversal(peak, after, float(first), float(settled), float(after - error[top:].min()) / peak)


def place_of_largest(run: Any, scenario: str) -> float:
    """Where the error is largest, as a part of the way from one reversal (0) to the next (1)."""
    at, half = reversal_time(scenario), math.pi / moving(scenario).rate_rad_s
    t = run["time"]
    inside = (t >= at) & (t < at + half)
    return float((t[inside][np.abs(run["true_error"][inside]).argmax()] - at) / half)


def elsewhere(run: Any, scenario: str) -> float:
    """Largest error in nm between two reversals, without a twentieth of a period after and a hundredth before one."""
    at, period = reversal_time(scenario), 2.0 * math.pi / moving(scenario).rate_rad_s
    t = run["time"]
    inside = (t >= at + 0.05 * period) & (t <= at + 0.49 * period)
    return 1e6 * float(np.abs(run["true_error"][inside]).max())


class AtRest(NamedTuple):
    """What goes on after a move, in the second half of its run."""

    error: float
    """Largest true error, um."""
    mean: float
    """Mean torque, of whole cycles where it oscillates, N m."""
    swing: float
    """Half of the torque's peak to peak, N m."""
    variation: float
    """Its total variation per second, N m/s."""


def at_rest(run: Any) -> AtRest:
    """What goes on in the second half of a run."""
    later = run["time"] >= 0.5 * run["time"][-1]
    torque, t = run["output"][later], run["time"][later]
    swing = 0.5 * float(np.ptp(torque))
    above = torque > 0.5 * (torque.max() + torque.min())
    rises = np.flatnonzero(~above[:-1] & above[1:])
    cycles = torque[rises[0] : rises[-1]] if len(rises) > 1 else torque
    variation = float(np.abs(np.diff(torque)).sum() / (t[-1] - t[0]))
    return AtRest(1e3 * float(np.abs(run["true_error"][later]).max()), float(np.mean(cycles)), swing, variation)


def settled_run(loops: Loops, law: str) -> Any:
    """1 mm in 50 ms with f_hat from the measured speed, sampled finely enough for the limit cycle that follows."""
    return loops.run(law, "step_quintic", 0.8, changes={"controller.friction_from": 2}, sample=2e-5)


def time_constant(run: Any, first: float, last: float) -> float:
    """Time constant in s of an error that decays as an exponential between two instants: least squares on its log."""
    t = run["time"]
    inside = (t >= first) & (t <= last)
    slope = np.polyfit(t[inside], np.log(np.abs(run["true_error"][inside])), 1)[0]
    return float(-1.0 / slope)


def stick_time_constant(law: Any) -> float:
    """``(sigma0 / J + 2 lam K / phi) / lam^3``: how slowly the integral of the complementary law moves a stuck stage.

    Derivation: stuck, the stage is a spring of ``sigma0``; ``J u = sigma0 (e - e_0)`` with (9), (10) and (15) at
    ``e' = 0`` leaves ``(sigma0 / J + 3 lam^2 + 2 lam K / phi) e + lam^3 xi = constant``, and ``xi' = e``. The term
    ``3 lam^2`` is a ten-thousandth of the rest.
    """
    p = law.params
    gain = p.bound.static / p.inertia + p.eta
    return float((LuGre().stiffness / p.inertia + 2.0 * p.lam * gain / p.boundary) / p.lam**3)
