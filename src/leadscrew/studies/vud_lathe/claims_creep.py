"""Claims about why the printed law creeps, and about the factors that replace (19): arithmetic and single runs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from leadscrew.controllers.vud.family import BETA_E, PRODUCT, UNITY, vud_family
from leadscrew.controllers.vud.universe import CENTRES, TABLE_2, contraction
from leadscrew.fuzzy.inference import infer, rule_base
from leadscrew.report.claim import Basis, Claim, Group, Kind, Sense, Verdict
from leadscrew.studies.vud_lathe.runs import PERIOD_S, STEPS

TAU, FLOOR, SPEED_MM_S = 0.9, 1e-4, 289.0
COUNT_MM, SCALE_MM, RATE_SCALE_MM = 0.000625, 190.0, 25.87
RULES = rule_base(CENTRES, CENTRES, TABLE_2)

Row = tuple[str, str, Group, Basis, str, float | str | None, float | str, str, Sense, float | str | None, float,
            Verdict, str, Kind]  # fmt: skip


def creep_claims(loops: Any) -> list[Claim]:
    """Every row of the digest's "Why L0 creeps", and the runs that go with it."""
    rows = [*_memory(), *_gains(), *_law(), *_flicker(), *_bound(), *_runs(loops)]
    return [
        Claim(f"vud_lathe.{n}", source, group, basis, statement, paper,
              measured if isinstance(measured, str) else float(measured), unit, sense, target, tolerance, kind,
              verdict, reason)
        for n, source, group, basis, statement, paper, measured, unit, sense, target, tolerance, verdict, reason, kind
        in rows
    ]  # fmt: skip


def answered(shape: float, periods: int, start: float, tau: float = TAU, floor: float = FLOOR) -> float:
    """The duty of (21) after some periods in which the rules say ``shape``."""
    rho = start
    for _ in range(periods):
        rho = contraction(rho, tau, floor, 1.0) * shape
    return rho


def resting(e: float, tau: float = TAU, floor: float = FLOOR, output_tau: float = TAU) -> float:
    """The duty at which the printed law comes to rest for a constant error and no rate."""
    shape = infer(RULES, -e / contraction(e, tau, floor, 1.0), 0.0)
    return answered(shape, 1000, 1.0, output_tau, floor)


# fmt: off
def _memory() -> Iterator[Row]:
    rest, bare = answered(0.677, 1000, 1.0), answered(0.677, 1000, 1.0, floor=0.0)
    deviation = [math.log(answered(0.677, k, 1.0, floor=0.0) / bare) for k in (10, 11)]
    constant = -1.0 / math.log(deviation[1] / deviation[0])
    seen = 0.02 / contraction(0.02, TAU, FLOOR, 1.0)
    shown = infer(RULES, -1.0, seen)
    yield ("creep_power", "(19), (21)", "as printed", "arithmetic", "resting duty for a constant 0.677, no floor", None,
           bare, "1", "=", 0.0202, 1e-4, "cannot be checked", f"0.677^(1/(1-0.9)) = {0.677**10:.4f}", "required")
    yield ("creep_power_floor", "(19), (21)", "as printed", "arithmetic", "resting duty for a constant 0.677", None,
           rest, "1", "=", 0.02089, 1e-5, "cannot be checked", "the floor of 0.0001 adds 3 %", "required")
    yield ("creep_speed", "(19), (21)", "as printed", "arithmetic", "its speed on an axis of 289 mm/s", None,
           SPEED_MM_S * rest, "mm/s", "=", 6.038, 0.001, "cannot be checked", "as the simulated axis creeps",
           "required")
    yield ("creep_time", "(19), (21)", "as printed", "arithmetic", "time constant of the way there", None, constant,
           "periods", "=", 10.0, 0.6, "cannot be checked", "-1/ln(0.9), in the logarithm of the duty", "report")
    yield ("creep_rate_seen", "(18)", "as printed", "arithmetic", "ec / alpha_ec at ec = 0.02, 5 mm/s", None, seen, "1",
           ">=", 0.67, 0.0, "cannot be checked", f"from there on the top row of Table 2 says {shown:.3f}",
           "required")
    for periods, expected, digit in ((1, 0.4998, 1e-4), (2, 0.359, 1e-3), (3, 0.2665, 1e-4), (4, 0.204, 1e-3),
                                     (60, 0.019, 1e-3)):
        duty = answered(0.67, periods, 0.722)
        first = periods == 1
        close = abs(duty - 0.4998) <= 5e-5
        verdict: Verdict = ("reproduced" if close else "not reproduced") if first else "cannot be checked"
        yield (f"example_decays_{periods}", "section V, example", "as printed", "arithmetic",
               f"duty {periods} ms after the worked example, rules held", 0.4998 if first else None, duty, "1", "=",
               expected, digit, verdict, "the example's own rule output 0.67 lets its duty of 0.722 decay",
               "required")
    grown, flipped = answered(1.0, 300, 1e-6), answered(-0.677, 1, 0.5)
    yield ("creep_regrows", "(19), (21)", "as printed", "arithmetic",
           "the duty grows again from 0.000001 and changes its sign", None,
           "yes" if grown > 0.99 and flipped < 0.0 else "no", "", "yes/no", "yes", 0.0, "cannot be checked",
           f"to {grown:.3f} where the rules say 1; it neither locks up nor dies", "required")


def _gains() -> Iterator[Row]:
    table = ((1.0, 1.0), (0.1, 3.5), (0.01, 10.3), (1e-3, 14.0), (1e-4, 5.6), (1e-5, 1.8))
    for number, (e, expected) in enumerate(table):
        yield (f"creep_gain_{number}", "(17), (19), (21)", "as printed", "arithmetic",
               f"resting duty over e at e = {e:g}, no rate", None, resting(e) / e, "1", "=", expected, 0.1,
               "cannot be checked", "rises as e falls, then the floor of 0.0001 takes over", "required")


def _law() -> Iterator[Row]:
    def slope(value: Any) -> float:
        return math.log(value(1e-6) / value(1e-8)) / math.log(100.0)

    none = 1e-30
    for tau, expected in ((0.9, 1.0), (0.8, 0.5)):
        measured = slope(lambda e, t=tau: resting(e, floor=none, output_tau=t))
        yield (f"factor_law_duty_{tau * 10:.0f}", "(17), (19)", "as printed", "arithmetic",
               f"power of e in the resting duty, exponents 0.9 and {tau:g}, no floor", None, measured, "1", "=",
               expected, 0.01, "cannot be checked", "(1 - tau_a) / (1 - tau_b): equal exponents give a linear law",
               "required")
    for tau in (0.5, 0.6):
        measured = slope(lambda e, t=tau: e ** (t - 1.0) * infer(RULES, -e / contraction(e, TAU, none, 1.0), 0.0))
        yield (f"factor_law_error_{tau * 10:.0f}", "(17), (19)", "as corrected", "arithmetic",
               f"power of e in duty over e where beta = |e|^{tau:g}, no floor", None, measured, "1", "=",
               round(tau - TAU, 1), 0.01, "cannot be checked",
               "tau_b - tau_a: the gain grows towards the target until the floor caps it", "required")


def _flicker() -> Iterator[Row]:
    ec = COUNT_MM * (0.1 / PERIOD_S) / RATE_SCALE_MM
    bare, seen = ec / contraction(ec, TAU, 0.0, 1.0), ec / contraction(ec, TAU, FLOOR, 1.0)
    yield ("flicker_ec", "(6)", "as printed", "arithmetic", "ec when the position changes by one count", None, ec, "1",
           "=", 0.0024, 1e-4, "cannot be checked", "0.625 um in 1 ms, scaled to 0.1 s", "required")
    yield ("flicker_seen", "(18)", "as printed", "arithmetic", "that ec on its contracted universe", None, bare, "1",
           "=", 0.55, 0.01, "cannot be checked",
           f"{seen:.3f} with the floor: one count swings the rules through half their range", "required")
    e = COUNT_MM / SCALE_MM
    shape = infer(RULES, -e / contraction(e, TAU, FLOOR, 1.0), 0.0)
    yield ("gain_at_a_count", "(17), (19)", "as corrected", "arithmetic",
           "speed over error at one count, beta = 1.5 (|e|^0.6 + 0.0001)", None,
           SPEED_MM_S * 1.5 * contraction(e, 0.6, FLOOR, 1.0) * shape / COUNT_MM, "1/s", "<=", 50.0, 0.0,
           "cannot be checked", "a loop with 25 ms of lag bears no more; the advice is a belief", "report")


def _bound() -> Iterator[Row]:
    lag = 0.0008 + 0.0015 + 0.017
    for way, expected, key in ((50.0, 0.200, "m50"), (170.0, 0.615, "m170")):
        yield (f"single_lag_bound_{key}", "(2), (3)", "ours", "arithmetic", f"shortest time for {way:g} mm", None,
               way / SPEED_MM_S + 2.0 * lag * math.log(2.0), "s", "=", expected, 0.001, "cannot be checked",
               f"full duty one way, then the other, with the lags as one of {1e3 * lag:.1f} ms", "required")


def _runs(loops: Any) -> Iterator[Row]:
    def position(seconds: float, **changes: Any) -> np.ndarray:
        run = loops.run(vud_family(**changes), STEPS[0], seconds=seconds, record=("actual.position",))
        return np.asarray(run["actual.position"])

    stuck = float(position(2.0, output_from=PRODUCT)[round(1.0 / PERIOD_S)])
    yield ("variant_beta_product_stuck", "(19)", "as corrected", "reconstructed plant",
           "where the move to -50 mm is after 1 s, beta from |e| |ec|", -50.0, stuck, "mm", "=", -0.24, 0.01,
           "not reproduced", "no rate, no duty, no rate", "required")
    late = position(4.0, output_from=UNITY)[round(2.0 / PERIOD_S) :] + 50.0
    crossings = np.flatnonzero(np.diff(np.signbit(late)))
    rate = (len(crossings) - 1) / (2.0 * PERIOD_S * float(crossings[-1] - crossings[0]))
    yield ("variant_beta_one_hertz", "(19)", "as corrected", "reconstructed plant",
           "frequency of the limit cycle, beta = 1", None, rate, "Hz", "=", 14.8, 0.1, "cannot be checked",
           "the paper reports no oscillation", "required")
    shift = np.abs(position(2.0, **BETA_E) - position(2.0, **BETA_E, output_first=1.0 / 1.5))
    yield ("first_gain_shift", "(19)", "as corrected", "reconstructed plant",
           "what the gain of 1.5 in the first period moves, at most", None, 1000.0 * float(shift.max()), "um", "=",
           48.0, 1.0, "cannot be checked", f"{1000.0 * float(shift[-1]):.2f} um of it are left after 2 s", "required")
# fmt: on
