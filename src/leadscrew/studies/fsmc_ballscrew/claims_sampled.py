"""Claims about controllers that a machine can run: 4 kHz, torque held over a period, a scale of 10 nm.

The paper samples nothing; what we ask of ourselves are the numbers of the project's digest, an earlier and independent
simulation of ours, to the digits that it gives. Where the stage sticks and slips, or the largest error is made by
single steps of the scale, values are not to be reproduced to digits; such rows report and say why.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from leadscrew.plants.ballscrew_stage import INERTIA
from leadscrew.report.claim import Claim, Kind, Sense
from leadscrew.studies.fsmc_ballscrew.runs import Loops, tail_um, travel_per_second
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES

WAY = dict(zip(SINES, ("0.01 sin t mm", "5 sin t mm", "sin 2 pi t mm"), strict=True))

REASONS = {
    "": "the paper does not sample",
    "slip": "the stage sticks and slips: the largest value changes by a third from one period to the next",
    "mean": "the digest's mean of s1 dz/dt takes the bristles' rate at the start of each of its 20 pieces, ours is the "
    "exact integral; done its way the fixed gains give its number (a test), the others come nearer",
    "count": "made by single steps of the scale: it differs by a tenth from one reversal to the next",
    "part": "depends on the part of the run that counts, which the digest does not name; here the second half",
    "form": "the digest's form without the mean is not printed; here the bristles move by the exact solution between "
    "samples, and their friction at the sample is nearly as good",
    "gains": "the digest prints no gains; these are of our own search",
}
"""Why a row reports only, by the mark in :data:`TABLE`."""


class Cell(NamedTuple):
    """A number of the digest, its last digit, and why it only reports."""

    value: float
    digit: float
    why: str = ""


def cell(text: str) -> Cell:
    """A number as printed, perhaps with a mark: ``0.237 mean``."""
    number, _, why = text.partition(" ")
    digits = len(number.split(".")[1]) if "." in number else 0
    return Cell(float(number), 10.0**-digits, why)


# fmt: off
TABLE: dict[str, tuple[str, tuple[tuple[str, str], ...]]] = {
    "ours.smc_layer": ("sliding mode, lam 150, slope 4000 1/s", (
        ("21 slip", "14"), ("11.9", "9.0 part"), ("13.8", "10.4"))),
    "ours.csmc_layer": ("complementary sliding mode, lam 150, slope 4000 1/s", (
        ("29 slip", "14"), ("3.32 part", "2.18 part"), ("11.8", "8.8"))),
    "ours.fsmc_4khz_slow": ("fuzzy sliding mode, lam 150", (
        ("7.7 slip", "1.9 slip"), ("0.446 count", "0.100 part"), ("1.16 mean", "0.76"))),
    "ours.csmc_tuned": ("complementary sliding mode, lam 600", (
        ("1.95 slip", "0.53 slip"), ("0.287 count", "0.043 count"), ("0.866 count", "0.297"))),
    "ours.fsmc_4khz": ("fuzzy sliding mode, tuned", (
        ("0.72 slip", "0.15 slip"), ("0.453 count", "0.027 count"), ("0.237 mean", "0.078 mean"))),
    "ours.fsmc_printed_4khz": ("fuzzy sliding mode, printed rules, tuned", (
        ("0.74 slip", "0.12 slip"), ("0.827 slip", "0.045 slip"), ("0.196 mean", "0.034"))),
    "ours.pid": ("PID without a friction model", (
        ("0.23 gains", "0.04 gains"), ("1.88 gains", "0.11 gains"), ("4.0 gains", "0.44 gains"))),
    "ours.super_twisting": ("super-twisting", (
        ("0.021 slip", "0.011"), ("0.60 slip", "0.32 slip"), ("0.88 slip", "0.33"))),
    "ours.pd_dob_fixed": ("PD with observer", (
        ("1.16 slip", "0.11 slip"), ("1.44 slip", "0.09 slip"), ("0.232 mean", "0.043 mean"))),
    "ours.pd_dob_aggressive": ("scheduled PD with observer, aggressive", (
        ("0.013", "0.0036"), ("0.076 count", "0.0075 count"), ("0.129 count", "0.0195 count"))),
    "ours.pd_dob_robust": ("scheduled PD with observer, robust", (
        ("0.064", "0.011"), ("0.095 count", "0.010"), ("0.195 mean", "0.055"))),
}
"""The digest's largest and RMS error in um on 0.01 sin t, 5 sin t and sin 2 pi t."""

WITHOUT_RATE = {
    "ours.fsmc_4khz": ("1.3 slip", "0.36 slip", "0.91 count"),
    "ours.fsmc_printed_4khz": ("0.88 slip", "0.45 slip", "0.87 count"),
    "ours.pd_dob_robust": ("0.065 slip", "0.087 count", "0.67"),
}
"""The digest's largest errors of a feed-forward without s1 dz/dt."""

RATE_OFF = {"controller.hat.damping": 0.0}

LIMITS = (0.07, 0.11, 0.21)
"""What the robust controller must keep to, um."""

CHANGED: dict[str, tuple[str, dict[str, Any], tuple[str, ...]]] = {
    "friction_up": ("20 % more friction than believed",
                    {"changes": {"plant.friction.coulomb": 1.2 * 6.24, "plant.friction.static": 1.2 * 9.36}},
                    ("0.050", "0.12", "0.356 count")),
    "inertia_up": ("30 % more inertia than believed", {"changes": {"plant.inertia": 1.3 * INERTIA}},
                   ("0.064", "0.088 count", "0.195 mean")),
    "10khz": ("sampled at 10 kHz", {"period": 1e-4}, ("0.069", "0.071", "0.166 mean")),
}
"""Another truth than the robust controller believes: the digest's largest errors."""
ON_GMS = ("0.083 slip", "0.21 count", "0.355 count")
"""The same on another friction model."""
# fmt: on


class Sampled:
    """What is asked of the runs of the sampled controllers."""

    def __init__(self, loops: Loops) -> None:
        self.run = loops.run

    def errors(self, name: str, scenario: str, **options: Any) -> tuple[float, float]:
        """Largest and RMS error in um in the second half; infinite where the loop diverges."""
        run = self.run(name, scenario, **options)
        return (math.inf, math.inf) if run.diverged else tail_um(run)


def row(
    name: str,
    statement: str,
    measured: float,
    unit: str,
    sense: Sense,
    target: float | None,
    tolerance: float,
    reason: str,
    kind: Kind = "required",
) -> Claim:
    """A claim about a number that the paper does not have."""
    return Claim(
        f"fsmc_ballscrew.sampled_{name}", "not in the paper", "ours", "printed plant", statement, None,
        float(measured), unit, sense, target, tolerance, kind, "cannot be checked", reason,
    )  # fmt: skip


def compared(name: str, statement: str, measured: float, text: str, unit: str = "um") -> Claim:
    """A number beside the digest's: required to half of its last digit, reported only where it has a mark."""
    target = cell(text)
    kind: Kind = "report" if target.why else "required"
    return row(
        name, statement, measured, unit, "=", target.value, 0.5 * target.digit * (1.0 + 1e-9), REASONS[target.why], kind
    )


def sampled_claims(loops: Loops) -> list[Claim]:
    """Every row about sampled controllers on a drive without lags."""
    runs = Sampled(loops)
    loops.ahead([(name, s, {}) for s in SINES for name in (*TABLE, "ours.pd_dob")])
    loops.ahead([(name, s, {"changes": RATE_OFF}) for s in SINES for name in WITHOUT_RATE])
    loops.ahead([("ours.pd_dob_robust", s, options) for s in SINES for _, options, _ in CHANGED.values()])
    return [*_table(runs), *_without_rate(runs), *_limits(runs), *_mean(runs), *_changed(runs), *_gain(runs),
            *_chatter(runs)]  # fmt: skip


def _key(name: str, scenario: str) -> str:
    return f"{name.removeprefix('ours.')}_{scenario}"


def _table(runs: Sampled) -> Iterator[Claim]:
    for name, (said, cells) in TABLE.items():
        for scenario, (largest, rms) in zip(SINES, cells, strict=True):
            found = runs.errors(name, scenario)
            way = f"on {WAY[scenario]} at 4 kHz, {said}"
            yield compared(f"{_key(name, scenario)}_max", f"largest error {way}", found[0], largest)
            yield compared(f"{_key(name, scenario)}_rms", f"RMS error {way}", found[1], rms)


def _without_rate(runs: Sampled) -> Iterator[Claim]:
    for name, texts in WITHOUT_RATE.items():
        for scenario, text in zip(SINES, texts, strict=True):
            found = runs.errors(name, scenario, changes=RATE_OFF)
            said = f"largest error on {WAY[scenario]} at 4 kHz, {TABLE[name][0]}, friction model without s1 dz/dt"
            yield compared(f"{_key(name, scenario)}_without_rate", said, found[0], text)


def _limits(runs: Sampled) -> Iterator[Claim]:
    for name in ("ours.pd_dob_robust", "ours.pd_dob"):
        for scenario, limit in zip(SINES, LIMITS, strict=True):
            said = f"largest error on {WAY[scenario]} at 4 kHz with a scale of 10 nm, {name}"
            yield row(f"{_key(name, scenario)}_limit", said, runs.errors(name, scenario)[0], "um", "<=", limit, 0.0,
                      REASONS[""])  # fmt: skip


def _mean(runs: Sampled) -> Iterator[Claim]:
    """What averaging the feed-forward over the hold is worth."""
    for pieces, text in ((0, "2.77 form"), (20, "0.23 mean")):
        found = runs.errors("ours.pd_dob_fixed", "sine_fast", changes={"controller.pieces": pieces})[0]
        said = "its mean over the coming period" if pieces else "its value at the sample"
        yield compared(f"feed_forward_pieces_{pieces}", f"largest error on sin 2 pi t mm, PD with observer, friction "
                       f"model as {said}", found, text)  # fmt: skip


def _changed(runs: Sampled) -> Iterator[Claim]:
    for key, (said, options, texts) in CHANGED.items():
        for scenario, text in zip(SINES, texts, strict=True):
            found = runs.errors("ours.pd_dob_robust", scenario, **options)[0]
            yield compared(f"robust_{key}_{scenario}", f"largest error on {WAY[scenario]}, robust controller, {said}",
                           found, text)  # fmt: skip
    less = {"plant.friction.coulomb": 0.8 * 6.24, "plant.friction.static": 0.8 * 9.36}
    for scenario in SINES:
        found = runs.errors("ours.pd_dob_robust", scenario, changes=less)[0]
        yield row(f"robust_friction_down_{scenario}", f"largest error on {WAY[scenario]}, robust controller, 20 % less "
                  "friction than believed", found, "um", "<=", None, 0.0, "over-compensation: the worse fault",
                  "report")  # fmt: skip
    other = [runs.errors("ours.pd_dob_robust", s, machine="gms")[0] for s in SINES]
    for scenario, text, found in zip(SINES, ON_GMS, other, strict=True):
        yield compared(f"robust_gms_{scenario}", f"largest error on {WAY[scenario]}, robust controller, on six Maxwell "
                       "elements in place of LuGre's bristles", found, text)  # fmt: skip
    worst = max(other)
    yield row("robust_gms_stable", "largest error on the three sines, robust controller on six Maxwell elements: it is "
              "stable", worst, "um", "<=", 1.0, 0.0, REASONS[""])  # fmt: skip


GAINS: Mapping[tuple[str, str], tuple[str, ...]] = {
    ("ours.pd_dob_robust", "ours.fsmc_4khz_slow"): ("120 slip", "4.7 count", "5.9"),
    ("ours.pd_dob_robust", "ours.fsmc_4khz"): ("11 slip", "4.8 count", "1.2 mean"),
    ("ours.pd_dob_aggressive", "ours.fsmc_4khz"): ("56 slip", "6 count", "1.8 mean"),
}
"""How many times smaller the digest's largest errors are than those of a fuzzy controller."""


def _gain(runs: Sampled) -> Iterator[Claim]:
    for (better, other), texts in GAINS.items():
        for scenario, text in zip(SINES, texts, strict=True):
            ratio = runs.errors(other, scenario)[0] / runs.errors(better, scenario)[0]
            name = f"{_key(better, scenario)}_over_{other.removeprefix('ours.')}"
            said = f"largest error on {WAY[scenario]} of {other} over that of {better}"
            yield compared(name, said, ratio, text, "1")
    least = min(
        runs.errors("ours.fsmc_4khz", s)[0] / runs.errors("ours.pd_dob_robust", s)[0] for s in SINES
    )  # fmt: skip
    yield row("robust_beats_tuned_fsmc", "largest error of the tuned fuzzy controller over the robust one's, least of "
              "three sines", least, "1", ">=", 1.0, 0.0, REASONS[""])  # fmt: skip


def _chatter(runs: Sampled) -> Iterator[Claim]:
    """The printed rules are not unstable when sampled: they chatter less than the corrected ones."""
    spread = {
        name: [travel_per_second(runs.run(name, s)) for s in SINES]
        for name in ("ours.fsmc_4khz", "ours.fsmc_printed_4khz")
    }
    known = {"ours.fsmc_4khz": ("80", "820"), "ours.fsmc_printed_4khz": ("60", "230")}
    why = "the digest gives a range of three sines, rounded; it depends on the period"
    for name, (low, high) in known.items():
        for end, text, found in (("least", low, min(spread[name])), ("most", high, max(spread[name]))):
            yield row(f"{name.removeprefix('ours.')}_variation_{end}", f"{end} variation of the torque a second of the "
                      f"three sines, {TABLE[name][0]}", found, "N m/s", "=", float(text), 0.0, why,
                      "report")  # fmt: skip
    ratio = max(spread["ours.fsmc_4khz"]) / max(spread["ours.fsmc_printed_4khz"])
    yield row("printed_rules_chatter_less", "variation of the torque with the corrected rules over that with the "
              "printed ones, largest of three sines", ratio, "1", ">=", 1.0, 0.0,
              "the printed rules act on error and integral, not on the rate")  # fmt: skip
    twisting = travel_per_second(runs.run("ours.super_twisting", "sine_wide"))
    yield row("super_twisting_variation", "variation of the torque a second on 5 sin t mm, super-twisting", twisting,
              "N m/s", "=", 3000.0, 500.0, "chatter: the digest says 3e3")  # fmt: skip
