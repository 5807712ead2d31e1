"""Claims about the shortest time that a step can take, and every settling on the axis with limits."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from leadscrew.report.claim import Claim, Group, Verdict
from leadscrew.studies.vud_lathe import limits as r
from leadscrew.studies.vud_lathe.claims_motion import ARRIVAL_S, FIGURE, KEY, NEAR_MM, WAY
from leadscrew.studies.vud_lathe.claims_motor import claim, motor_claims
from leadscrew.studies.vud_lathe.runs import STEPS, Loops

SINGLE_LAG_S = (0.200, 0.615)
"""Digest, section 7: bound of the single-lag formula."""
EXPECTED_LIMITED_S = (0.22, 0.70)
"""What the issue says the bound is about on the limited axis."""
NO_PAPER = "the paper does not ask how fast the axis could be"
HALF_COUNT = 0.5 / 1000.0


def limits_claims(loops: Loops) -> list[Claim]:
    """All of them."""
    return [*motor_claims(), *_bounds(loops), *_settling(loops), *_timer(loops), *_current(loops)]


def _bounds(loops: Loops) -> Iterator[Claim]:
    for scenario, printed, expected in zip(STEPS, SINGLE_LAG_S, EXPECTED_LIMITED_S, strict=True):
        way, key, distance = WAY[scenario], KEY[scenario], r.WAY_MM[scenario]
        to = f"to {way} mm"
        top = r.AXIS.top_speed_mm_s
        free, limited = r.bound(distance, False), r.bound(distance, True)
        formula, clipped = r.one_lag_s(distance), r.one_lag_s(distance, top)
        ceiling = r.single_lag_time(distance, top, r.LAGS_S)
        yield claim(f"bound_one_lag_{key}", "not in the paper", f"least time {to}, lags taken as one", formula, "s",
                    "=", printed, 0.0005, f"D/K_v + 2 T ln 2, T = 19.3 ms; {NO_PAPER}", kind="required")  # fmt: skip
        yield claim(f"bound_linear_{key}", "not in the paper", f"least time to within 2 um {to}, linear axis",
                    free.time_s, "s", "=", formula, 0.0015,
                    f"linear programme over all duties; one period less leaves {1000.0 * free.one_less:.1f} um; "
                    f"the target is the formula's", kind="required")  # fmt: skip
        yield claim(f"bound_limited_{key}", "not in the paper", f"least time to within 2 um {to}, limited axis",
                    limited.time_s, "s", "=", clipped, 0.0015,
                    f"the same with 7.5 A and {top} mm/s at most; one period less leaves "
                    f"{1000.0 * limited.one_less:.1f} um; the target is the one-lag formula's with a top speed",
                    kind="required")  # fmt: skip
        yield claim(f"bound_ceiling_{key}", "not in the paper",
                    f"least time {to} if the top speed is what a lower voltage leaves", ceiling, "s", "=", expected,
                    0.01, f"another reading of {top} mm/s, D/{top} + 2 T ln 2, which the data do not exclude; "
                    f"about {expected:.2f} s was expected")  # fmt: skip
        played = r.played(distance, True)
        after = np.abs(played.error_um[limited.periods :])
        yield claim(f"bound_played_{key}", "not in the paper",
                    f"largest error {to} after the least time, the sequence played on the limited axis itself",
                    after.max(), "um", "<=", 2.0, 0.0,
                    f"largest current {np.abs(played.current).max():.2f} A, largest speed "
                    f"{np.abs(played.speed).max():.1f} mm/s", kind="required")  # fmt: skip
        for axis, run, least in (("linear", r.on_linear, free), ("limited", r.on_limited, limited)):
            times = {c: run(loops, c, scenario).metrics["settling_2um"] for c in r.tried()}
            arrived = {c: t for c, t in times.items() if math.isfinite(t)}
            first = min(arrived, key=arrived.__getitem__)
            yield claim(f"bound_beaten_{axis}_{key}", "not in the paper",
                        f"a controller is within 2 um of {way} mm before the least time, {axis} axis",
                        "yes" if arrived[first] < least.time_s - 1e-9 else "no", "", "yes/no", "no", 0.0,
                        f"the first of {len(times)} is {first} after {arrived[first]:.3f} s, "
                        f"{1000.0 * (arrived[first] - least.time_s):.0f} ms above it", kind="required")  # fmt: skip


def _settling(loops: Loops) -> Iterator[Claim]:
    """What the claims of the linear machine say, on the limited one."""
    for controller in r.tried():
        whose, name = controller.split(".")
        group: Group = {"paper": "as printed", "corrected": "as corrected"}.get(whose, "ours")  # type: ignore[assignment]
        for scenario in STEPS:
            run = r.on_limited(loops, controller, scenario)
            plain = r.on_linear(loops, controller, scenario)
            way, key = WAY[scenario], KEY[scenario]
            at = int(np.searchsorted(run.time, ARRIVAL_S[scenario]))
            away = abs(float(run["command"][at] - run["actual.position"][at]))
            still = standing_words(controller)
            end_um = 1000.0 * abs(float(run["command"][-1] - run["actual.position"][-1]))
            rows: list[tuple[str, str, float, float, str, float, bool, str]] = [
                ("1pct", FIGURE[scenario], ARRIVAL_S[scenario], run.metrics["settling_1pct"], "s",
                 plain.metrics["settling_1pct"], away <= NEAR_MM,
                 f"{away:.1f} mm away at {ARRIVAL_S[scenario]:g} s, which is read as near within {NEAR_MM:.0f} mm"),
                ("2um", "Figure 12", 2.0, run.metrics["settling_2um"], "s", plain.metrics["settling_2um"],
                 run.metrics["settling_2um"] <= 2.0, still),
                ("error", "Figure 12", 2.0, 1000.0 * run.metrics["error_after_2s"], "um",
                 1000.0 * plain.metrics["error_after_2s"], 1000.0 * run.metrics["error_after_2s"] <= 2.0,
                 f"{end_um:.1f} um at {run.time[-1]:.0f} s; {still}"),
            ]  # fmt: skip
            says = {"1pct": f"within 1 % of {way} mm", "2um": f"within 2 um of {way} mm",
                    "error": f"largest error at {way} mm for t > 2 s"}  # fmt: skip
            for row, source, paper, measured, unit, linear, met, why in rows:
                said: Verdict = "not reproduced" if not met else (
                    "reproduced" if whose == "paper" else "reproduced with change"
                )  # fmt: skip
                never = "" if math.isfinite(measured) else "not within the run; "
                yield claim(
                    f"limited_{name}_{row}_{key}", source if whose != "ours" else "not in the paper",
                    f"{controller} on the limited axis: {says[row]}", measured, unit, "=", None, 0.0,
                    f"{never}linear axis: {linear:.3f} {unit}; {why}",
                    paper=None if whose == "ours" else paper, verdict="cannot be checked" if whose == "ours" else said,
                    group=group,
                )  # fmt: skip


def standing_words(controller: str) -> str:
    """How far from its target a law may stand, because what it asks for is rounded to nothing."""
    far = r.standing_um(controller, HALF_COUNT)
    if not far:
        return "for one count of its sensor it asks for half a PWM count of 1,000: it does not stand still"
    return f"where its sensor reads up to {far:.3g} um it asks for less than half a PWM count of 1,000, and stands"


def _timer(loops: Loops) -> Iterator[Claim]:
    """What rounding to counts costs, and what carrying the remainder over gives back."""
    settled = {"corrected.vud_beta_e": (1.0, 1.6), "ours.pd": (0.30, 0.78)}
    for controller, allowed in settled.items():
        name = controller.split(".")[1]
        for scenario, limit in zip(STEPS, allowed, strict=True):
            key, way = KEY[scenario], WAY[scenario]
            loop = loops.get(controller, scenario, machine="limited")
            runs = {
                what: loop.using(changes).run(4.0, record=()).metrics
                for what, changes in (
                    ("carry", {"actuator.carry": True}), ("five", {"actuator.minimum_on_counts": 5}),
                )
            }  # fmt: skip
            rounded = r.on_limited(loops, controller, scenario).metrics["error_after_2s"]
            kept, coarse = runs["carry"], runs["five"]
            yield claim(f"pwm_carry_2um_{name}_{key}", "not in the paper",
                        f"{controller} within 2 um of {way} mm, limited axis, remainder of the PWM carried over",
                        kept["settling_2um"], "s", "<=", limit, 0.0,
                        "the mean duty is right again, at the price of single counts switching", kind="required",
                        group="as corrected" if controller.startswith("corrected") else "ours")  # fmt: skip
            yield claim(f"pwm_carry_error_{name}_{key}", "not in the paper",
                        f"{controller}: largest error at {way} mm for t > 2 s, remainder carried over",
                        1000.0 * kept["error_after_2s"], "um", "<=", 0.3125, 0.0,
                        f"{1000.0 * rounded:.2f} um without", kind="required",
                        group="as corrected" if controller.startswith("corrected") else "ours")  # fmt: skip
            yield claim(f"pwm_shortest_error_{name}_{key}", "not in the paper",
                        f"{controller}: largest error at {way} mm for t > 2 s, no pulse below 5 of 1,000 counts",
                        1000.0 * coarse["error_after_2s"], "um", "<=", r.standing_um(controller, 4.5e-3), 0.625,
                        "it stands where the law asks for less than that; the tolerance is a count of the grating",
                        kind="required")  # fmt: skip


def _current(loops: Loops) -> Iterator[Claim]:
    peaks = {
        (c, s): float(np.abs(r.on_limited(loops, c, s)["plant.current"]).max()) for c in r.tried() for s in STEPS
    }  # fmt: skip
    most = max(peaks, key=peaks.__getitem__)
    limit = r.AXIS.current_limit_a
    yield claim("current_moves", "section II", "largest current of any controller in both moves", peaks[most], "A",
                "<=", limit, 0.0, f"{most[0]}, {WAY[most[1]]} mm: the limit never acts, and does not slow any of them",
                kind="required")  # fmt: skip
    reversal = r.reversal_peak_a(True)
    volts = r.AXIS.supply_v * (1.0 + r.AXIS.top_speed_mm_s / r.AXIS.full_duty_speed_mm_s)
    yield claim("current_reversal", "section II", "largest current after a full reversal at top speed, unlimited",
                reversal, "A", ">=", limit, 0.0,
                f"supply and back-EMF together are {volts:.1f} V, {volts / r.AXIS.resistance_ohm:.2f} A over the "
                "resistance, but the axis has slowed down before the current is there", kind="required")  # fmt: skip
    most_played = max(float(np.abs(r.played(r.WAY_MM[s], True).current).max()) for s in STEPS)
    yield claim("current_fastest", "section II", "largest current of the fastest moves", most_played, "A", "<=",
                limit, 1e-9, "only full braking at top speed needs the peak current", kind="required")  # fmt: skip
