"""The add-ons that the paper recommends as future work: a tracking differentiator and a dead-zone compensator."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from leadscrew.actuators.dead_zone import dead_zone
from leadscrew.analysis.stability import Margins, margins, sampled_loop
from leadscrew.controllers.dead_zone_inverse import dead_zone_inverse
from leadscrew.controllers.npid import npid
from leadscrew.controllers.pid import TUNINGS as PID
from leadscrew.controllers.pid import pid
from leadscrew.controllers.tracking_differentiator import TUNINGS as FOLLOWED
from leadscrew.controllers.tracking_differentiator import follow, tracking_differentiator
from leadscrew.kernel.block import Block
from leadscrew.report.claim import Claim
from leadscrew.studies.npid_xytable.calibration import BASE_HZ, PERIOD_S
from leadscrew.studies.npid_xytable.runs import Loops, build
from leadscrew.studies.npid_xytable.saying import said, verdict_of, word
from leadscrew.studies.npid_xytable.scenarios import SCENARIOS
from leadscrew.studies.npid_xytable.sines import LATE, SINE_S, read, rms, sines

LOST_UM = 100.0
"""RMS error from which a loop counts as lost: the drive then swings from limit to limit."""

FILTERS_S = np.array([0.2e-3, 0.5e-3, 1e-3])
NO_LIMIT = 1e15
"""r of a follower that is linear for every error of a claim, mm/s^2."""

DRIVE = dead_zone(threshold=0.02, subtract=True)
"""A drive that loses 20 mV of every output."""

corrected = partial(said, group="as corrected")


def add_on_claims(loops: Loops) -> list[Claim]:
    """Digest section 8.8."""
    return [*_differentiator(loops), *_dead_zone(loops)]


def followed_rate(h_s: float, r_mm_s2: float = 1000.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rate of the error by difference, followed, and true, mm/s: 10 s of a 1 mm sine, encoder 0.5 um, noise 0.1 um.

    The error is the 7.12 um that Table I's PID leaves.
    """
    t, w = PERIOD_S * np.arange(20_000), 2.0 * math.pi * BASE_HZ
    error, rate = 7.12e-3 * np.sin(w * t), 7.12e-3 * w * np.cos(w * t)
    read = np.sin(w * t) - error + 1e-4 * np.random.default_rng(0).normal(size=t.size)
    seen = np.sin(w * t) - 5e-4 * np.floor(read / 5e-4 + 0.5)
    x1, x2, rates = float(seen[0]), float(rate[0]), np.empty(t.size)
    for k, v in enumerate(seen.tolist()):
        x1, x2 = follow(x1, x2, v, r_mm_s2, h_s, PERIOD_S)
        rates[k] = x2
    return np.diff(seen, prepend=seen[0] - PERIOD_S * rate[0]) / PERIOD_S, rates, rate


def rate_errors(h_s: float) -> tuple[float, float]:
    """RMS errors of the error's rate, mm/s, by difference and followed."""
    plain, followed, true = followed_rate(h_s)
    return float(rms(plain - true)), float(rms((followed - true)[2000:]))


def margins_of(block: Block) -> Margins:
    """Margins of a linear controller in L*."""
    return margins(sampled_loop(build(block, SCENARIOS["sine_1mm"])))


# fmt: off
def _differentiator(loops: Loops) -> Iterator[Claim]:
    source = "abstract, section IV"
    plain, fast = rate_errors(1e-3)
    slow = rate_errors(2e-3)[1]
    yield said("td_rate_plain", source, "error of a backward difference of the tracking error, encoder 0.5 um", plain,
               "mm/s", 0.49, "rms; rounding and noise of 0.176 um a reading make 0.497 of it: the digest's last digit "
               "hangs on the draw", tolerance=0.01)
    yield said("td_rate_1ms", source, "the same by a tracking differentiator, r = 1000 mm/s^2, h = 1 ms", fast, "mm/s",
               0.096, f"{plain / fast:.1f} times less", tolerance=1e-3)
    yield said("td_rate_2ms", source, "the same, h = 2 ms", slow, "mm/s", 0.029, "the noise alone leaves 0.027; what "
               "the digest has more is lag, which depends on how fast its error moved, and that is not in it",
               tolerance=5e-4, kind="report")
    h, r = np.array([1e-3, 0.5e-3, 2e-3, 1e-3]), np.array([1000.0, 1000.0, 1000.0, 200.0])
    block = tracking_differentiator(npid)
    changes = {"controller.inner.alpha": np.repeat([0.0, npid.params.alpha], h.size), "controller.h_s": np.tile(h, 2),
               "controller.r_mm_s2": np.tile(r, 2)}
    size, _, calm = read(loops, block, changes)
    without = read(loops, npid, {"controller.alpha": np.array([0.0])})
    yield said("td_du_plain", source, "change of the output from period to period, PID, 1 mm sine, encoder 0.5 um",
               float(without[2][0]), "mV", 6.1, "rms, the derivative of the rounding; 6.1 and 6.2 in the digest, by "
               "the draw", tolerance=0.1)
    yield said("td_du", source, "the same, PID by a tracking differentiator, r = 1000 mm/s^2, h = 1 ms", float(calm[0]),
               "mV", 1.2, f"{without[2][0] / calm[0]:.1f} times calmer", tolerance=0.05)
    yield said("td_same_rms", source, "rms error of it, of that of the PID", float(size[0] / without[0][0]), "1", 1.0,
               f"{size[0]:.3f} and {without[0][0]:.3f} um: it calms the drive and does not touch the error",
               tolerance=0.005)
    yield said("td_too_slow", source, "rms error of the PID with r = 200 mm/s^2, h = 1 ms", float(size[3]), "um", 18.9,
               "a limit cycle that the encoder's noise starts: the follower's rate cannot turn as fast as the error's. "
               "18.9 in the digest, from another draw of noise", tolerance=0.05, kind="report")
    lost = size[h.size :]
    followed = margins_of(tracking_differentiator(pid, r_mm_s2=NO_LIMIT, h_s=1e-3)).gm
    yield corrected("td_npid_lost", source, "whether Table I's NPID is lost with every one of four such "
                    "differentiators", word(bool((lost > LOST_UM).all())), "", "yes", f"rms errors {lost.min():.0f} to "
                    f"{lost.max():.0f} um, the drive at its limits; with h = 1 ms the gain margin is {followed:.2f}",
                    sense="yes/no")
    margin = {f: margins_of(pid(filter_s=f)).gm for f in FILTERS_S.tolist()}
    for f, target in ((0.5e-3, 2.04), (1e-3, 1.81)):
        yield said(f"filter_margin_{1e6 * f:.0f}us", source, f"gain margin of Table I's PID, derivative filtered by "
                   f"{1e3 * f:g} ms", margin[f], "1", target, "2.51 without filter; NPID asks for 2.35",
                   tolerance=0.005)
    filtered = {"controller.filter_s": FILTERS_S}
    free, cutting = sines(loops, npid, "sine_1mm", filtered)[0], sines(loops, npid, "measured_1000", filtered)[0]
    yield corrected("filter_npid_lost", source, "whether Table I's NPID is lost with filters of 0.5 and 1 ms",
                    word(bool((free[1:] > LOST_UM).all())), "", "yes", f"rms errors {free[1]:.0f} and {free[2]:.0f} um "
                    "on a 1 mm sine", sense="yes/no")
    yield corrected("filter_npid_02ms", source, "rms error of Table I's NPID with a filter of 0.2 ms, 1 mm sine",
                    float(free[0]), "um", LOST_UM, f"finite, as the digest says, but the gain margin of "
                    f"{margin[0.2e-3]:.3f} lies below 2.352: under cutting forces it is lost too, "
                    f"{cutting[0]:.0f} um", sense="<=")
    ours = FOLLOWED["ours.pid_td"]
    peaks = [margins_of(b).ms for b in (PID["ours.pid_ms_159"], ours(r_mm_s2=NO_LIMIT))]
    calm_td, calm_pid = (float(read(loops, block, _as(b))[2][0]) for b in (ours, None))
    yield said("td_price", source, "peak of sensitivity of ours.pid_td", peaks[1], "1", 1.87, f"{peaks[0]:.2f} with "
               f"plain differences, whose output changes by {calm_pid:.2f} mV from period to period, this by "
               f"{calm_td:.2f} mV", sense="<=")
    improves = bool(size[0] < 0.99 * without[0][0] or (lost < LOST_UM).any())
    yield said("future_differentiator", source, "whether a tracking differentiator improves tracking here",
               word(improves), "", "no", "with PID the error "
               "is the same and the drive calmer, with Table I's NPID the loop is lost", sense="yes/no",
               paper="to improve the tracking performance", verdict=verdict_of(improves))


def _as(block: Any) -> dict[str, np.ndarray]:
    """The keys of ``tracking_differentiator(npid)`` that make it ``block``, or ours of Ms 1.59 by plain differences."""
    gains = PID["ours.pid_ms_159"].params
    r, h = (block.params.r_mm_s2, block.params.h_s) if block is not None else (NO_LIMIT, PERIOD_S)
    values = {"inner.alpha": 0.0, "r_mm_s2": r, "h_s": h}
    values |= {f"inner.{key}": getattr(gains, key) for key in ("kp", "ki", "kd")}
    return {f"controller.{key}": np.array([value]) for key, value in values.items()}


def _dead_zone(loops: Loops) -> Iterator[Claim]:
    source = "abstract, section IV"
    loop = build(dead_zone_inverse(pid), SCENARIOS["sine_1mm"], actuator=DRIVE)
    shares = np.array([0.0, 0.8, 1.0, 1.0, 1.2])
    changes = {"controller.width": DRIVE.params.threshold * shares,
               "controller.softness": np.array([1e-3, 1e-3, 1e-3, 0.0, 1e-3])}
    e = 1e3 * loop.batch(SINE_S, changes, record="true_error")["true_error"]
    found = rms(e[:, LATE:])
    healthy = float(sines(loops, npid, "sine_1mm", {"controller.alpha": np.array([0.0])})[0][0])
    table = partial(said, tolerance=0.005)
    yield table("dead_zone_none", source, "rms error of Table I's PID on a 1 mm sine, healthy drive", healthy, "um",
                5.04, "before the dead zone")
    yield said("dead_zone_bare", source, "the same, dead zone of 20 mV in the drive", float(found[0]), "um", 19.5,
               f"{found[0] / healthy:.1f} times as much", tolerance=0.05)
    yield table("dead_zone_full", source, "the same, compensated by u + 20 mV tanh(u / 1 mV)", float(found[2]), "um",
                5.06, f"without softening {found[3]:.3f} um, the healthy drive's")
    yield table("dead_zone_80", source, "the same, 80 % of it compensated", float(found[1]), "um", 7.85,
                "what is not known stays a dead zone of 4 mV")
    yield said("dead_zone_120", source, "the same, 120 % of it compensated", float(found[4]), "um", None,
               "what is too much acts as a relay: here the error falls, a drive with noise would chatter",
               kind="report")
    helps = bool(found[2] < 0.5 * found[0])
    yield said("future_dead_zone", source, "whether a dead-zone compensator helps a drive with a dead zone",
               word(helps), "", "yes", f"{found[0]:.1f} to {found[2]:.2f} um", sense="yes/no",
               paper="to improve the tracking performance", verdict=verdict_of(helps))
