"""Margins of the linear loop: of gain, phase and delay, and the peaks of sensitivity.

    GM = 1 / abs(G) where G crosses the negative real axis        PM, delay margin PM / w where abs(G) = 1
    Ms = max abs(1 / (1 + G))                                     Mt = max abs(G / (1 + G))
    disk margin = 2 / max abs((1 - G) / (1 + G)), balanced (skew 0)

Every crossing is refined to the last digits, the dead time is exact. Of several crossings the one with the least margin
counts. The delay margin of a sampled loop is that of its response between the samples taken as continuous; extra delay
there comes in whole steps of the drive's clock.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate, number, of_loop
from leadscrew.analysis.stability.linear import (
    Crossing,
    LinearLoop,
    gain_crossings,
    given_grid,
    own_grid,
    phase_crossings,
    worst_pole,
)
from leadscrew.analysis.stability.multiplier import highest


@dataclass(frozen=True, eq=False, repr=False)
class Margins(Certificate):
    """The margins as a certificate (of the linear loop alone), with the numbers by name."""

    gm: float = math.nan
    """Gain margin: the factor by which the gain may grow; infinite where there is no crossing above."""
    gm_down: float = 0.0
    """Factor to which the gain may fall; 0 where it may vanish."""
    pm_deg: float = math.nan
    """Phase margin, deg."""
    delay_s: float = math.nan
    """Delay margin, s."""
    ms: float = math.nan
    """Peak of the sensitivity."""
    mt: float = math.nan
    """Peak of the complementary sensitivity."""
    w_pc: float = math.nan
    """Phase crossover of the least gain margin, rad/s."""
    w_gc: float = math.nan
    """Gain crossover of the least phase margin, rad/s."""
    w_ms: float = math.nan
    """Frequency of the sensitivity's peak, rad/s."""
    phase: tuple[Crossing, ...] = ()
    gain: tuple[Crossing, ...] = ()

    @cached_property
    def disk(self) -> float:
        """Disk margin, 0 to 2: gain and phase may change at once, the gain alone by ``(2 + disk) / (2 - disk)``."""
        if not self.proved:
            return math.nan
        loop, gain = self.data["loop"], self.data["gain"]

        def unbalanced(w: np.ndarray) -> np.ndarray:
            g = gain * loop.response(w)
            return np.abs((1.0 - g) / (1.0 + g))

        return 2.0 / highest(unbalanced, own_grid(loop).w)[0]

    def __repr__(self) -> str:
        if not self.proved:
            return f"<Margins {self.loop['name']}: {self.statement}>"
        gain = (
            f"gain {number(self.gm)} at {self.w_pc:.4g} rad/s, phase {number(self.pm_deg)} deg at {self.w_gc:.4g} rad/s"
        )
        peaks = f"delay {number(1e3 * self.delay_s)} ms, Ms {self.ms:.4g}, Mt {self.mt:.4g}, disk {self.disk:.4g}"
        return f"<Margins {self.loop['name']}: {gain}, {peaks}>"


def margins(loop: LinearLoop, gain: float = 1.0, grid: Any = None) -> Margins:
    """Margins of ``gain * G``: one certificate, refused where that loop is unstable (the crossings are given still).

    Args:
        loop: cut at the error.
        gain: constant gain in front, for example the one that a nonlinearity saturates at.
        grid: frequencies in rad/s; the loop's own where not given.
    """
    wrong: list[str] = []
    own = own_grid(loop)
    if grid is not None:
        own, wrong = given_grid(loop, grid)
    scaled = loop
    if gain != 1.0:
        c, d = gain * loop.c, gain * loop.d
        scaled = LinearLoop(loop.a, loop.b, c, d, loop.dt, loop.dead_time, loop.name, loop.notes, loop.from_blocks)
    phase, crossed = phase_crossings(scaled, own.w), gain_crossings(scaled, own.w)
    up = min((c for c in phase if c.value > -1.0), key=lambda c: -1.0 / c.value, default=None)
    down = min((c for c in phase if c.value < -1.0), key=lambda c: -c.value, default=None)
    least = min(crossed, key=lambda c: _signed(c.value), default=None)
    late = min(crossed, key=lambda c: c.value / c.w, default=None)
    ms, w_ms = highest(lambda w: np.abs(1.0 / (1.0 + scaled.response(w))), own.w)
    mt, _ = highest(lambda w: np.abs(scaled.response(w) / (1.0 + scaled.response(w))), own.w)
    stable = loop.stable(gain)
    gm = math.inf if up is None else -1.0 / up.value
    pm = math.inf if least is None else math.degrees(_signed(least.value))
    with_gain = "" if gain == 1.0 else f" with a gain of {gain:.4g} in front"
    if wrong:
        statement = wrong[0]
    elif stable:
        statement = (
            f"The linear loop{with_gain} is stable: gain margin {number(gm)}, phase margin {number(pm)} deg, "
            f"sensitivity peak Ms {ms:.3g}."
        )
    else:
        statement = f"The linear loop{with_gain} is unstable ({worst_pole(loop, gain)}): it has no margins."
    good = stable and not wrong
    return Margins(
        "margins", "grid-checked" if good else "refused", statement, of_loop(loop), None, gain * gm if good else None,
        gm if good else None, None, own.as_dict(), [*loop.notes, *wrong],
        {"gm": gm, "pm_deg": pm, "ms": ms, "mt": mt, "gain": gain, "loop": loop}, "nyquist",
        gm if good else math.nan, 0.0 if down is None else -1.0 / down.value, pm if good else math.nan,
        (math.inf if late is None else late.value / late.w) if good else math.nan,
        ms if good else math.nan, mt if good else math.nan,
        math.nan if up is None else up.w, math.nan if least is None else least.w, w_ms, tuple(phase), tuple(crossed),
    )  # fmt: skip


def _signed(angle: float) -> float:
    """A phase margin between -pi and pi."""
    return angle if angle <= math.pi else angle - 2.0 * math.pi
