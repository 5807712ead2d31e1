"""Claims about real drives: what every sub-0.1 um number becomes with a limit, lags, ripple, delay and an axial mode.

The paper has none of this; nothing here judges it.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from leadscrew.kernel.loop import DivergenceWarning
from leadscrew.report.claim import Claim, Kind, Sense
from leadscrew.studies.fsmc_ballscrew.driven import DRIVES, Found, errors_um, survivors
from leadscrew.studies.fsmc_ballscrew.runs import Loops, tail_um
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES

SUB_MICROMETRE = {
    "ours.pd_dob": SINES,
    "ours.pd_dob_robust": SINES,
    "ours.pd_dob_aggressive": SINES,
    "ours.pd_learned": SINES,
    "ours.super_twisting": ("sine_slow",),
}
"""Controllers with errors below 0.1 um at 4 kHz, and where."""

JUDGED = ("ours.pd_dob",)
"""Those of them that the report shows; the page ``docs/drive_realism.md`` has all."""

HOLDING = {
    "ours.pd_dob_delay": "delay",
    "ours.pd_dob_late": "delay_filter",
    "ours.pd_dob_1khz": "1khz",
    "ours.pd_dob_drive": "all",
    "ours.pd_dob_drive_1khz": "all_1khz",
}
"""Settings made for a drive."""

LONG_S = 8.0
"""How long a loop that may burst into oscillation is watched on sin 2 pi t."""

EMPTY, FULL = 2.12e-4, 2.12e-4 + 62.4 * (1.5923e-3) ** 2
"""Inertia at the screw without and with the paper's largest table and work, kg m^2."""

LADEN = (
    "ours.smc_4khz", "ours.csmc_4khz", "ours.csmc_tuned", "ours.smc_integral_4khz", "ours.fsmc_4khz_slow",
    "ours.fsmc_4khz", "ours.fsmc_printed_4khz", "ours.super_twisting", "ours.pid", "ours.pd_dob_fixed",
    "ours.pd_dob_aggressive", "ours.pd_dob_robust", "ours.pd_dob",
)  # fmt: skip
"""The sampled controllers whose errors are stated for an empty and a full table."""

NOT_IN = "not in the paper"


def _row(
    name: str, statement: str, measured: float | str, unit: str, sense: Sense, target: float | None, reason: str,
    kind: Kind = "report",
) -> Claim:  # fmt: skip
    value = measured if isinstance(measured, str) else float(measured)
    return Claim(
        f"fsmc_ballscrew.{name}", NOT_IN, "ours", "printed plant", statement, None, value, unit, sense, target, 0.0,
        kind, "cannot be checked", reason,
    )  # fmt: skip


def said(found: Found) -> str:
    """The largest error in um to two digits that count, or that the loop is unstable."""
    return f"{found.largest:.2g}" if math.isfinite(found.largest) else "unstable"


def table(loops: Loops, names: Iterable[str] = tuple(SUB_MICROMETRE)) -> dict[tuple[str, str], list[Found]]:
    """Errors on the sines of :data:`SUB_MICROMETRE`, by controller and drive."""
    return {
        (name, drive): [errors_um(loops, name, scenario, drive) for scenario in SUB_MICROMETRE[name]]
        for name in names
        for drive in DRIVES
    }


def drive_claims(loops: Loops) -> list[Claim]:
    """Every row about real drives, and about the inertia of the table."""
    return [*_each(loops), *_holding(loops), *_delay(loops), *inertia_claims(loops)]


def _each(loops: Loops) -> Iterator[Claim]:
    for (name, drive), found in table(loops, JUDGED).items():
        on = "0.01 sin t" if len(found) == 1 else "0.01 sin t, 5 sin t, sin 2 pi t"
        yield _row(f"drive_{name.removeprefix('ours.')}_{drive}", f"largest error on {on} mm, {name}, "
                   f"{DRIVES[drive].said}", " / ".join(said(f) for f in found), "um", "=", None,
                   "from rest; unstable: leaves the track by more than 0.1 mm")  # fmt: skip


def _holding(loops: Loops) -> Iterator[Claim]:
    for name, drive in HOLDING.items():
        found = [errors_um(loops, name, scenario, drive) for scenario in SINES]
        worst = max(f.largest for f in found)
        yield _row(f"drive_holds_{drive}", f"largest error on the three sines, {name}, "
                   f"{DRIVES[drive].said}: it holds", worst, "um", "<=", 50.0,
                   " / ".join(said(f) for f in found) + " um on 0.01 sin t, 5 sin t, sin 2 pi t mm",
                   "required")  # fmt: skip
    found = [errors_um(loops, "ours.pd_dob_late", scenario, "delay_filter") for scenario in SINES]
    yield _row("drive_moonshot_late", "largest error on the three sines with one sample of delay and a scale filtered "
               "at 1 kHz", max(f.largest for f in found), "um", "<=", 0.05,
               " / ".join(said(f) for f in found) + " um; both lags are known to the controller, which looks ahead",
               "moonshot")  # fmt: skip


def _delay(loops: Loops) -> Iterator[Claim]:
    """One sample of delay, on eight amplitudes of sin 2 pi t that differ by a ten-thousandth each."""
    for name in ("ours.pd_dob_delay", "ours.pd_dob_robust", "ours.pd_dob", "ours.pd_dob_aggressive"):
        held = survivors(loops, name, "sine_fast", "delay", seconds=LONG_S)
        ours = name == "ours.pd_dob_delay"
        why = "tuned with the delay in the loop" if ours else (
            "the digest and a single run call the robust gains stable; before each reversal the raised gains amplify "
            "for some samples, and whether that dies away is chance"
        )  # fmt: skip
        yield _row(f"drive_delay_survivors_{name.removeprefix('ours.')}", f"of 8 runs of {LONG_S:g} s on sin 2 pi t mm "
                   f"with one sample of delay, how many stay within 10 um, {name}", held, "1", ">=", 8.0, why,
                   "required" if ours else "report")  # fmt: skip


def laden(inertia: float) -> dict[str, Any]:
    """Options of a run on a table with that inertia at the screw; none for the full table."""
    return {} if inertia == FULL else {"changes": {"plant.inertia": inertia}}


def inertias(loops: Loops, name: str, scenario: str, values: list[float]) -> list[float]:
    """Largest error in um in the second half on a sine of the study, by the plant's inertia; infinite if unstable."""
    found = []
    for value in values:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DivergenceWarning)
            run = loops.run(name, scenario, **laden(value))
        found.append(math.inf if run.diverged else tail_um(run)[0])
    return found


def inertia_claims(loops: Loops) -> Iterator[Claim]:
    """The paper's future work: errors with an empty and with a full table, all gains as for the full one."""
    loops.ahead([(name, s, laden(value)) for s in SINES[1:] for name in LADEN for value in (EMPTY, FULL)])
    grown = {}
    for name in LADEN:
        ends = [inertias(loops, name, scenario, [EMPTY, FULL]) for scenario in SINES[1:]]
        grown[name] = max(empty / full for empty, full in ends)
        text = ", ".join(f"{said(Found(empty, 0.0))} / {said(Found(full, 0.0))}" for empty, full in ends)
        yield Claim(
            f"fsmc_ballscrew.inertia_{name.removeprefix('ours.')}", "section 7, future work", "ours", "printed plant",
            f"largest error on 5 sin t, sin 2 pi t mm, empty / full table, {name}", None, text, "um", "=", None, 0.0,
            "report", "cannot be checked", "2.12e-4 and 3.70e-4 kg m^2; the controller believes the full table",
        )  # fmt: skip
    least = max(grown["ours.pd_dob_robust"], grown["ours.pd_dob"])
    yield _row("inertia_robust_growth", "largest error with an empty table over that with a full one, robust "
               "controllers, worst of two sines", least, "1", "<=", 2.0, "friction, not inertia, makes the error",
               "required")  # fmt: skip


def sweep(loops: Loops, name: str, values: np.ndarray) -> list[float]:
    """Largest errors on sin 2 pi t over a range of inertias."""
    return inertias(loops, name, "sine_fast", [float(v) for v in values])
