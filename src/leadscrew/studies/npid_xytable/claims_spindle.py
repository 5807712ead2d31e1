"""Claims about spindle speeds up to 24,000 1/min: who lets which line through, and what folding does."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from leadscrew.report.claim import Claim
from leadscrew.studies.npid_xytable.runs import Loops
from leadscrew.studies.npid_xytable.saying import said, word
from leadscrew.studies.npid_xytable.spindle_sweep import (
    APART,
    GHOST_RPM,
    LAST_RPM,
    NYQUIST_HZ,
    RPM,
    SWEPT,
    TOOTH_MV,
    SpindleSweep,
    line,
    seen_hz,
    tooth_hz,
)

SOURCE = "section IV"
PLAIN = "ours.pid_ms_159"
CHATTER_RPM = 2850.0


def spindle_claims(loops: Loops, found: SpindleSweep | None = None) -> list[Claim]:
    """All of them; ``found`` keeps what pictures need too."""
    found = found or SpindleSweep(loops)
    return [*_closed_form(found), *_speeds(found), *_chatter(found), *_folding(found), *_ghost(found)]


def _closed_form(found: SpindleSweep) -> Iterator[Claim]:
    for name, expected in found.expected.items():
        swept = found.swept[name]
        off = max(
            float(np.abs(getattr(swept, what) / getattr(expected, what) - 1.0)[APART].max())
            for what in ("spindle", "tooth")
        )
        yield said(
            f"sweep_closed_form_{name.split('.')[-1]}", SOURCE, f"largest relative difference of simulated "
            "amplitudes from "
            f"abs(S P) d, {name}, {len(RPM)} speeds", off, "", 1e-6,
            "both lines, above Nyquist too: the folded line is the line itself times the sampled sensitivity",
            sense="<=",
        )  # fmt: skip


def _speeds(found: SpindleSweep) -> Iterator[Claim]:
    for name in SWEPT:
        swept, key = found.swept[name], name.split(".")[-1]
        for what, volts in (("spindle", "1 mV of runout"), ("tooth", "2 mV at four teeth")):
            values = getattr(swept, what)
            worst = int(np.argmax(values))
            yield said(
                f"sweep_worst_{what}_{key}", SOURCE, f"largest error at the {what} line, {volts}, 500 to 24,000 "
                f"1/min, {name}",
                values[worst], "um", None, f"at {RPM[worst]:,.0f} 1/min; at 1,000, 3,000 and 24,000 1/min about "
                f"{', '.join(f'{np.interp(r, RPM, values):.3f}' for r in (1000, 3000, LAST_RPM))} um", kind="report",
            )  # fmt: skip
    worse = found.swept[PLAIN].spindle / found.swept["paper.pid"].spindle
    above = RPM[worse > 1.1]
    yield said(
        "sweep_retuned_is_worse", SOURCE, "error at the spindle line of ours.pid_ms_159 over that of Table I's PID, "
        "worst "
        "speed", worse.max(), "", None, f"at {RPM[int(np.argmax(worse))]:,.0f} 1/min; more than 1.1-fold from "
        f"{above.min():,.0f} to {above.max():,.0f} 1/min: what takes the lines at 2 to 8 Hz pays at 15 to 130 Hz",
        kind="report",
    )  # fmt: skip
    below = tooth_hz(1.0) * RPM < NYQUIST_HZ
    rest = [
        float((found.swept["resonant"].spindle / found.swept[PLAIN].spindle)[APART].max()),
        float((found.swept["resonant"].tooth / found.swept[PLAIN].tooth)[below].max()),
    ]
    yield said(
        "sweep_resonators_take_the_lines", SOURCE, "what resonators at the known lines leave of them below Nyquist, "
        "worst "
        "speed", max(rest), "", 0.01, f"spindle {100 * rest[0]:.2f} %, teeth {100 * rest[1]:.2f} %; the rest is still "
        "decaying after 10 s at strength 1", sense="<=",
    )  # fmt: skip


def _chatter(found: SpindleSweep) -> Iterator[Claim]:
    at = int(np.flatnonzero(RPM == CHATTER_RPM)[0])
    npid, plain = (found.swept[name].tooth[at] for name in ("corrected.npid_um", "paper.pid"))
    yield said(
        "sweep_npid_chatter", SOURCE, "error of NPID over that of PID at the teeth, 2,850 1/min: 190 Hz",
        npid / plain, "",
        5.0, f"{npid:.2f} against {plain:.3f} um: the teeth pass at the frequency of NPID's own limit cycle, which "
        "locks on",
        sense=">=",
    )  # fmt: skip


def _folding(found: SpindleSweep) -> Iterator[Claim]:
    hz = tooth_hz(GHOST_RPM)
    at = int(np.flatnonzero(RPM == GHOST_RPM)[0])
    free, closed = (TOOTH_MV * line(block, hz).sampled for block in (None, SWEPT[PLAIN]))
    yield said(
        "sweep_folded_amplitude", SOURCE, f"error at {seen_hz(hz):.0f} Hz under ours.pid_ms_159, teeth at {hz:,.0f} Hz",
        found.swept[PLAIN].tooth[at], "um", closed, f"a free table moves {free:.5f} um at {hz:,.0f} Hz, and the loop's "
        f"sensitivity at {seen_hz(hz):.0f} Hz is {closed / free:.3f}; far below a count of 0.5 um, as all that "
        "millivolts "
        "do above 1 kHz", tolerance=1e-6,
    )  # fmt: skip
    together = [found.swept[PLAIN].tooth[-1], found.swept[PLAIN].spindle[-1]]
    yield said(
        "sweep_indistinguishable", SOURCE, "at 24,000 1/min the samples show spindle (400 Hz) and teeth (1,600 Hz) "
        "as one line",
        word(math.isclose(*together, rel_tol=1e-9)), "", "yes", f"{together[0]:.4f} um at 400 Hz for both; only "
        "another "
        "sampling rate or an anti-alias filter tells them apart", sense="yes/no",
    )  # fmt: skip


def _ghost(found: SpindleSweep) -> Iterator[Claim]:
    hz = tooth_hz(GHOST_RPM)
    plain, ghost = line(SWEPT[PLAIN], hz), line(SWEPT[PLAIN], hz, cancelled=True)
    yield said(
        "sweep_ghost_sampled", SOURCE, f"error at the samples under a resonator at {seen_hz(hz):.0f} Hz, teeth at "
        f"{hz:,.0f} "
        "Hz", found.ghost_um, "um", 1e-4, "the encoder shows that the line is gone", sense="<=",
    )  # fmt: skip
    yield said(
        "sweep_ghost_motion", SOURCE, "and the true motion of the table then, over that without the resonator, rms",
        ghost.rms / plain.rms, "", 1.2, f"{TOOTH_MV * ghost.own:.5f} um at {hz:,.0f} Hz and a ghost of "
        f"{TOOTH_MV * ghost.ghost:.5f} um at {seen_hz(hz):.0f} Hz, which the controller makes to hide it from the "
        "samples; "
        f"near 2 kHz it is {_near_the_rate():.3f}-fold", sense=">=",
    )  # fmt: skip


def _near_the_rate() -> float:
    hz = 1990.0
    return line(SWEPT[PLAIN], hz, cancelled=True).rms / line(None, hz).rms
