"""What is read from runs: errors, torque, what a reversal leaves, what goes on at rest."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.studies.fsmc_ballscrew.scenarios import SAMPLE_S, sine_of
from leadscrew.studies.lab import Lab, measure

LAWS = ("corrected.smc", "paper.smc", "paper.csmc", "corrected.fsmc", "paper.fsmc")
"""In continuous time, with the printed gains."""

SECONDS = {"sine_slow": 8.4, "sine_wide": 8.4, "sine_fast": 3.0}
"""How long a sine runs."""

WINDOW = {"sine_slow": (3.0, 8.4), "sine_wide": (3.0, 8.4), "sine_fast": (1.0, 3.0)}
"""What counts of it, in seconds: two reversals of the slow sines, four of the fast one."""
SAMPLES = {"sine_slow": SAMPLE_S, "sine_wide": SAMPLE_S, "sine_fast": 5e-5}
"""Interval between samples, s; the peak after a reversal of the fast sine asks for a finer one."""


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


def sine_run(lab: Lab, law: str, scenario: str, **options: Any) -> Any:
    """The run of a law in continuous time on a sine."""
    return lab.run(law, scenario, SECONDS[scenario], **({"sample": SAMPLES[scenario]} | options))


def tracked(lab: Lab, law: str, scenario: str, **options: Any) -> Tracked:
    """What is read from the run of a sine; NaN after a divergence."""
    run, (first, last) = sine_run(lab, law, scenario, **options), WINDOW[scenario]
    t = run["time"]
    inside = (t >= first) & (t <= last)
    if run.diverged or not inside.any():
        return Tracked(math.nan, math.nan, math.nan, math.nan)
    e, torque = 1e3 * run["true_error"][inside], run["output"][inside]
    variation = np.abs(np.diff(torque)).sum() / (t[inside][-1] - t[inside][0])
    return Tracked(
        float(np.abs(e).max()), math.sqrt(float(np.mean(e * e))), float(np.abs(torque).max()), float(variation)
    )


def rate_rad_s(run: Any) -> float:
    """Largest rate of the error after three tenths of a run, rad/s."""
    late = run["time"] > 0.3 * run["time"][-1]
    return float(np.abs((run["actual.velocity"] - run["command.velocity"])[late]).max()) / TRAVEL_MM_PER_RAD


def tail_um(run: Any, after: float = 0.5) -> tuple[float, float]:
    """Largest and root-mean-square true error, um, after the part ``after`` of a run; infinite if it diverged."""
    if run.diverged:
        return math.inf, math.inf
    e = 1e3 * run["true_error"]
    e = e[int(after * len(e)) :]
    return float(np.abs(e).max()), float(np.sqrt(np.mean(e * e)))


@measure
def sampled_error_um(lab: Lab, controller: str, scenario: str, inertia: float | None = None) -> np.ndarray:
    """True error of a whole scenario, um; infinite if the loop diverges."""
    loop = lab.loop(controller, scenario, changes={} if inertia is None else {"plant.inertia": inertia})
    run = loop.run(lab.study.scenario(scenario).duration_s, record=("true_error",))
    return np.full(2, math.inf) if run.diverged else 1e3 * run["true_error"]


def largest_um(lab: Lab, controller: str, scenario: str, inertia: float | None = None) -> float:
    """Largest true error in the second half of a scenario, um."""
    e = sampled_error_um(lab, controller, scenario, inertia)
    return float(np.abs(e[len(e) // 2 :]).max())


def travel_per_second(run: Any, after: float = 0.5) -> float:
    """Total variation of the torque per second in the later part of a run, N m/s."""
    u, t = run["output"], run["time"]
    first = int(after * len(u))
    return float(np.abs(np.diff(u[first:])).sum() / (t[-1] - t[first]))


def left_um(lab: Lab, law: str, scenario: str) -> float:
    """True error at the end of a step's run, um."""
    return 1e3 * float(abs(lab.run(law, scenario)["true_error"][-1]))


def error_um(lab: Lab, law: str, scenario: str) -> float:
    """Largest error on a sine, or what a step leaves, um."""
    return tracked(lab, law, scenario).largest if scenario in SECONDS else left_um(lab, law, scenario)


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


def reversal_time(scenario: str) -> float:
    """Instant of a reversal of a sine that lies inside :data:`WINDOW` with its neighbourhood, s."""
    rate = sine_of(scenario).rate_rad_s
    return (1.5 if rate < 2.0 else 5.5) * math.pi / rate


def reversal(run: Any, scenario: str) -> Reversal:
    """The reversal of :func:`reversal_time`, looked at for a tenth of a period."""
    at, period = reversal_time(scenario), 2.0 * math.pi / sine_of(scenario).rate_rad_s
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
    at, half = reversal_time(scenario), math.pi / sine_of(scenario).rate_rad_s
    t = run["time"]
    inside = (t >= at) & (t < at + half)
    return float((t[inside][np.abs(run["true_error"][inside]).argmax()] - at) / half)


def elsewhere(run: Any, scenario: str) -> float:
    """Largest error in nm between two reversals, without a twentieth of a period after and a hundredth before one."""
    at, period = reversal_time(scenario), 2.0 * math.pi / sine_of(scenario).rate_rad_s
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


def settled_run(lab: Lab, law: str) -> Any:
    """1 mm in 50 ms with f_hat from the measured speed, sampled finely enough for the limit cycle that follows."""
    return lab.run(law, "step_quintic", 0.8, changes={"controller.friction_from": "measured_undamped"}, sample=2e-5)
