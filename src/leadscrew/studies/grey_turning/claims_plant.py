"""Claims about the process that was reconstructed: its open loop, and the noise-free loop at given times."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from leadscrew.report.claim import Claim
from leadscrew.studies.grey_turning.machines import PERIOD_S
from leadscrew.studies.grey_turning.reproduction import WORDS, Reproduction
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.grey_turning.saying import said

CLOCK_S = 1e-3
"""A step of integration. The digest's force at a time is that at the end of the step that begins then."""
FEED_V = 35.5 / 150.0
"""The voltage of 35.5 mm/min: 150 N at 1 mm."""
OPEN = {0.04: 35.95, 0.08: 106.17, 0.1: 129.02, 0.15: 149.75, 0.2: 150.45, 0.5: 150.00}
"""Force in N after a step of :data:`FEED_V`, by time in s; section 4 of the digest."""
OPEN_FILTERED = {0.1: 56.53, 0.2: 118.84, 0.5: 148.90}
STIFFNESS = {10_000.0: 115.2, 40_000.0: 136.5, 1e9: 144.1}
"""Force at 0.1 s by stiffness in N/mm; 1e9 is rigid."""
TIMES = (0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0, 2.0)
CLOSED = {
    "s6_tfc": (12.06, 44.29, 66.81, 88.32, 132.49, 153.12, 148.63, 149.97),
    "s6_b": (12.01, 41.77, 66.10, 89.96, 133.63, 149.13, 150.64, 149.99),
    "s9_tfc": (53.83, 187.26, 215.13, 142.09, 149.48, 156.14, 143.56, 151.27),
    "s9_b": (53.49, 155.66, 160.67, 140.38, 155.34, 147.41, 151.09, 150.02),
    "stfc_tfc": (24.61, 92.43, 133.62, 145.33, 148.53, 149.75, 149.96, 150.00),
}
"""Filtered force in N at :data:`TIMES`; A6 of the digest."""
HALF, FINE = 40, 100
"""Steps of the plant a period, for what the step of 1 ms costs."""

open_loop = partial(said, source="equation (1)")


def plant_claims(loops: Loops, found: Reproduction | None = None) -> list[Claim]:
    """A5, A6, and the numbers of section 4 that belong to them."""
    found = found or Reproduction(loops)
    return [*_open(loops), *_closed(found), *_step_size(loops, found)]


def open_response(loops: Loops, stiffness: float = 20_000.0, seconds: float = 0.6) -> np.ndarray:
    """Force every millisecond after a step of the feed voltage to :data:`FEED_V`, without noise and runout, N.

    The voltage is that of a TFC that is held to a lower limit and whose rules say nothing.
    """
    held = {"controller.lower": FEED_V, "controller.output_scale": 1e-30, "plant.stiffness": stiffness}
    loop = loops.get("corrected.tfc_s6", "noise_free", period=CLOCK_S, substeps=1, changes=held)
    return np.asarray(loop.run(seconds, record=("actual",))["actual.force"])


def _open(loops: Loops) -> Iterator[Claim]:
    force = open_response(loops)
    for t, target in OPEN.items():
        k = round(t / CLOCK_S) + 1
        yield open_loop(
            f"open_loop_force_{1e3 * t:.0f}ms", statement="force after a step to 35.5 mm/min, at the end of the step "
            f"of 1 ms that begins at {1e3 * t:.0f} ms", measured=float(force[k]), unit="N", target=target,
            tolerance=0.02 * target, reason=f"plant F; the digest counts so; at {1e3 * t:.0f} ms itself "
            f"{force[k - 1]:.2f} N, {100.0 * (force[k - 1] / target - 1.0):+.1f} % from its number; "
            "the force of (1) builds up over servo, a revolution of 50 ms, and the tool's yielding",
        )  # fmt: skip
    held = {"controller.lower": FEED_V, "controller.output_scale": 1e-30}
    y = np.asarray(loops.get("corrected.tfc_s6", "noise_free", changes=held).run(0.6, record=("feedback",))["feedback"])
    for t, target in OPEN_FILTERED.items():
        yield open_loop(
            f"open_loop_filtered_{1e3 * t:.0f}ms", statement=f"the same after the digital filter, at {1e3 * t:.0f} ms",
            measured=float(y[round(t / PERIOD_S)]), unit="N", target=target, tolerance=0.02 * target,
            reason="the filter of 0.8 delays slow changes by four samples",
        )  # fmt: skip
    reached = [CLOCK_S * float((force >= share * 150.0).argmax()) for share in (0.1, 0.9)]
    filtered = [PERIOD_S * float((y >= share * 150.0).argmax()) for share in (0.1, 0.9)]
    for name, (a, b), target, words in (
        ("force", reached, 0.082, "of the force"), ("filtered", filtered, 0.22, "after the filter"),
    ):  # fmt: skip
        yield open_loop(
            f"open_loop_rise_{name}", statement=f"time from 10 to 90 % {words}", measured=b - a, unit="s",
            target=target, tolerance=5e-4 if name == "force" else 5e-3,
            reason="no force loop that reads the filtered force can look faster than the filter",
        )  # fmt: skip
    for stiffness, target in STIFFNESS.items():
        force = open_response(loops, stiffness, 0.15)
        rigid = stiffness > 1e6
        words = "rigid" if rigid else f"{1e-3 * stiffness:.0f} kN/mm"
        yield open_loop(
            f"open_loop_{'rigid' if rigid else f'{1e-3 * stiffness:.0f}kn_mm'}",
            statement="force at the end of the step that begins at 100 ms, tool and work "
            f"{words}", measured=float(force[101]), unit="N", target=target, tolerance=0.02 * target,
            reason=f"a yielding tool opens the chip later; at 100 ms itself {force[100]:.2f} N",
        )  # fmt: skip


def _closed(found: Reproduction) -> Iterator[Claim]:
    for name, row in CLOSED.items():
        factors, law = name.split("_")
        y = found.quiet[name].y[0]
        at = np.array([y[round(t / PERIOD_S)] for t in TIMES])
        off = 100.0 * np.abs(at / np.array(row) - 1.0)
        listed = ", ".join(f"{v:.2f}" for v in at)
        yield said(
            f"noise_free_{name}", "Figures 6, 7, 9 and 10", "largest distance of the filtered force from the digest's, "
            f"{WORDS[law]} with {factors.upper()}, plant F, at eight times", float(off.max()), "%", 3.0,
            f"noise-free, at {', '.join(f'{t:g}' for t in TIMES)} s: {listed} N",
            sense="<=",
        )  # fmt: skip


def _step_size(loops: Loops, found: Reproduction) -> Iterator[Claim]:
    for name, tuned, target, paper in (
        ("s9_tfc", "corrected.tfc_s9", 48.56, 48.6), ("s9_b", "corrected.gpfc_b_s9", 12.33, 12.7),
    ):  # fmt: skip
        words = WORDS[name.split("_")[1]]
        half, fine = (
            np.asarray(loops.get(tuned, "noise_free", substeps=n).run(2.1, record=("feedback",))["feedback"])
            for n in (HALF, FINE)
        )
        coarse = found.quiet[name].y[0]
        samples = [round(t / PERIOD_S) for t in TIMES]
        off, finer = (np.abs(y[samples] - coarse[samples])[1:] for y in (half, fine))
        yield said(
            f"step_size_{name}", "Figures 9 and 10", "largest change of the filtered force from 0.2 s on when the "
            f"plant is stepped by 0.5 ms in place of 1 ms, {words} with S9", float(off.max()), "N", 1.5,
            f"with 0.2 ms {finer.max():.2f} N at {TIMES[1 + int(finer.argmax())]:g} s; the digest names the bound, not "
            "its step", sense="<=",
        )  # fmt: skip
        yield said(
            f"fine_overshoot_{name}", "Figures 9 and 10", f"noise-free overshoot with steps of 0.2 ms, {words} with S9",
            100.0 * (float(fine.max()) / 150.0 - 1.0), "%", target,
            f"with 1 ms {100.0 * (coarse.max() / 150.0 - 1.0):.2f} %; the servo was fitted to the paper's {paper:g} %",
            tolerance=0.05, basis="fitted to this number",
        )  # fmt: skip
