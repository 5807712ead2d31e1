"""What is asked of a criterion: a loop, a sector, perhaps the nonlinearity itself; and why it may be refused.

The best multiplier of a frequency condition, and a grid that grows where the condition is tightest.

Every criterion here asks that ``h(w, q) = r(w) + q s(w)`` stays below ``1 / (k2 - k1)`` at all frequencies. As the
largest of straight lines in ``q``, ``max_w h`` is convex: its least value is found by halving on the slope of the
active line, and is the best that the criterion can give.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate, interval, number, of_loop
from leadscrew.analysis.stability.linear import Grid, LinearLoop, given_grid, own_grid
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.analysis.stability.lure import Lure


SMALL_ERROR_MM = 0.01
"""Error at which a nonlinearity in a useful unit already does something."""
CONDITIONAL = (
    "The loop is stable with a gain of 1 but not with every smaller one, as strong integral action or resonators make "
    "it"
)
NOTHING = 1e-3
"""Share of its full effect below which it does nothing there."""


@dataclass
class Question:
    """A sector asked of a loop, with the loop transformed so that the sector starts at 0: ``G1 = G / (1 + k1 G)``."""

    criterion: str
    loop: LinearLoop
    k1: float
    k2: float | None
    grid: Grid
    nyquist: float
    """Largest gain above ``k1`` up to which the linear loop is stable."""
    critical: bool
    """Whether the transformed loop has a pole on its boundary: the integrator, with ``k1 = 0``."""
    warnings: list[str] = field(default_factory=list)
    refusal: str = ""
    seen: np.ndarray | None = field(default=None, repr=False)
    """The response on the grid, once it was asked for."""

    def response(self, w: np.ndarray) -> np.ndarray:
        """``G1`` at the frequencies ``w``."""
        if w is self.grid.w:
            if self.seen is None:
                g = self.loop.response(w)
                self.seen = g / (1.0 + self.k1 * g)
            return self.seen
        g = self.loop.response(w)
        return g / (1.0 + self.k1 * g)

    @property
    def lower(self) -> str:
        """How the sector begins, in words."""
        return f"{self.k1:g} {'<' if self.critical else '<='}"

    def refused(self, sentence: str = "", data: dict[str, Any] | None = None, drawing: str = "") -> Certificate:
        """The certificate of a refusal."""
        return Certificate(
            self.criterion, "refused", sentence or self.refusal, of_loop(self.loop), self.sector,
            grid=self.grid.as_dict(), warnings=self.warnings, data=data or {}, drawing=drawing,
        )  # fmt: skip

    @property
    def sector(self) -> tuple[float, float]:
        """What was asked for."""
        return self.k1, math.inf if self.k2 is None else self.k2


def ask(
    criterion: str,
    loop: LinearLoop,
    k1: float | None,
    k2: float | None,
    nonlinearity: Lure | None = None,
    w: Any = None,
    static: bool = True,
) -> Question:
    """The question, with every reason to refuse it looked for. ``static``: whether phi must be a map of the error.

    Raises:
        ValueRefused: bounds that are not finite numbers in order.
    """
    if k1 is None:
        k1 = 0.0 if nonlinearity is None else float(nonlinearity.sector[0])
    if k2 is None and nonlinearity is not None and nonlinearity.nonlinear:
        k2 = float(nonlinearity.sector[1])
    if not math.isfinite(k1) or (k2 is not None and not (math.isfinite(k2) and k2 > k1)):
        raise ValueRefused(
            f"{criterion}: sector [{k1!r}, {k2!r}]: allowed are finite numbers, the first below the second"
        )
    wrong: list[str] = []
    grid = own_grid(loop)
    if w is not None:
        grid, wrong = given_grid(loop, w)
    limit = loop.gain_limit(k1)
    at_k1 = loop.stable(k1)
    asked = Question(criterion, loop, float(k1), k2, grid, limit, not at_k1 and limit > k1, [*loop.notes, *wrong])
    asked.refusal = _refusal(asked, nonlinearity, static, wrong)
    if k1 < limit < 1.0 and loop.stable(1.0):
        asked.warnings.append(f"{CONDITIONAL}: begin the sector at the controller's least gain, not at {k1:g}.")
    if nonlinearity is not None:
        asked.warnings += _remarks(asked, nonlinearity)
    return asked


def _refusal(asked: Question, nonlinearity: Lure | None, static: bool, wrong: list[str]) -> str:
    loop, k1, k2 = asked.loop, asked.k1, asked.k2
    if asked.nyquist <= k1:
        gain = k1 if k1 != 0.0 else 1.0
        if loop.stable(gain):
            return f"{CONDITIONAL}: no sector from {k1:g} can be proved; begin it at the controller's least gain."
        return (
            f"The loop is unstable with a gain of {gain:g} ({worst_pole(loop, gain)}): it has to be stabilised before "
            "any sector that contains that gain can be asked about."
        )
    if k2 is not None and k2 >= asked.nyquist:
        return (
            f"The sector {interval(k1, k2)} reaches beyond the Nyquist limit: with a constant gain of "
            f"{asked.nyquist:.4g} the loop already oscillates, so no criterion can prove more."
        )
    if wrong:
        return wrong[0]
    if nonlinearity is None:
        return ""
    low, high = nonlinearity.sector
    if static and nonlinearity.dependent:
        return (
            f"The gain of {nonlinearity.block.name} multiplies the controller's output: it is no static map of the "
            f"error, which {asked.criterion} asks for; the circle criterion holds for it."
        )
    if low < k1 - 1e-9:
        return (
            f"The nonlinearity does not keep to the sector's lower bound: its gain falls to {low:.4g}, below {k1:g}; "
            f"ask for {interval(low, high)}."
        )
    if k2 is not None and high > k2 + 1e-9:
        return (
            f"The nonlinearity does not keep to the sector's upper bound: its gain reaches {high:.4g}, above {k2:g}; "
            f"ask for {interval(low, high)}."
        )
    return ""


def worst_pole(loop: LinearLoop, gain: float) -> str:
    poles = loop.closed_poles(gain)
    if loop.dt is not None:
        z = poles[np.argmax(np.abs(poles))]
        return f"a pole at |z| = {abs(z):.6g}"
    s = poles[np.argmax(poles.real)]
    return f"a pole at {s.real:.4g} {'+-' if s.imag else ''}{f' {abs(s.imag):.4g}j' if s.imag else ''} 1/s".replace(
        "  ", " "
    )


def _remarks(asked: Question, nonlinearity: Lure) -> list[str]:
    low, high = nonlinearity.sector
    found = list(nonlinearity.notes)
    if asked.k1 < low - 1e-9:
        found.append(
            f"The nonlinearity's gain is never below {low:.4g}; the sector from {asked.k1:g} asks for more than needed."
        )
    done = abs(float(nonlinearity.gain(SMALL_ERROR_MM)) - float(nonlinearity.gain(0.0)))
    if high > low and done < NOTHING * (high - low):
        found.append(
            f"The nonlinearity counts its error in {nonlinearity.error_unit}: at an error of "
            f"{1e3 * SMALL_ERROR_MM:g} um its gain has changed by {done:.2g} of {high - low:.3g}. If the axis errs by "
            "micrometres the controller is a linear one; is the unit right?"
        )
    slopes = nonlinearity.slope_sector
    limit = asked.nyquist
    if slopes is not None and slopes[1] > limit:
        found.append(
            f"The slope of the nonlinearity reaches {slopes[1]:.4g}, above the Nyquist limit of {number(limit)}: a "
            "load or a following error that holds the error there makes the loop oscillate, whatever is proved of the "
            "loop left alone. Ask driven()."
        )
    return found


Lines = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Frequencies to intercepts ``r`` and slopes ``s``."""

ROUNDS = 20
HALVINGS = 200
SETTLED = 1e-9
"""Relative change of the condition's value at which refinement stops."""
WIDEST = 1e6
"""Largest multiplier tried, in units of the first step."""


@dataclass(frozen=True)
class Best:
    """The least ``m = max_w (r + q s)`` and where it is taken."""

    m: float
    q: float
    at: float
    """Frequency of the tightest point, rad/s; infinity for the limit at high frequency."""
    w: np.ndarray
    """The grid as it ended."""
    added: int
    settled: bool
    """Whether the maximum was bracketed: finer grids no longer change it."""


def best(
    lines: Lines,
    w: np.ndarray,
    q: float | None,
    low: float,
    high: float,
    unit: float,
    limits: tuple[tuple[float, float], ...] = (),
    rounds: int = ROUNDS,
) -> Best:
    """The best multiplier between ``low`` and ``high`` (or the given ``q``), on a grid refined around every maximum.

    ``limits`` are the ``(r, s)`` towards which the condition goes at infinite frequency; ``unit`` is the size of a
    multiplier that changes something, where the search starts; ``rounds`` of 1 leaves the grid as it is.
    """
    start = len(w)
    end_r, end_s = (np.array([x[k] for x in limits]) for k in (0, 1))
    r, s = lines(w)
    last = np.nan
    settled = False
    for left in range(rounds, 0, -1):
        every_r, every_s = np.append(r, end_r), np.append(s, end_s)
        chosen = q if q is not None else _least(every_r, every_s, low, high, unit)
        h = every_r + chosen * every_s
        m = float(h.max())
        if abs(m - last) <= SETTLED * max(abs(m), abs(last)):
            settled = True
            break
        if left == 1:
            break
        last = m
        new = _between(w, h[: len(w)])
        more_r, more_s = lines(new)
        w, r, s = np.append(w, new), np.append(r, more_r), np.append(s, more_s)
        order = np.argsort(w)
        w, r, s = w[order], r[order], s[order]
    k = int(np.argmax(h))
    return Best(m, float(chosen), float(w[k]) if k < len(w) else np.inf, w, len(w) - start, settled)


def _least(r: np.ndarray, s: np.ndarray, low: float, high: float, unit: float) -> float:
    """The ``q`` of the least ``max(r + q s)``, or one where that is already below 0."""

    def look(q: float) -> tuple[float, float]:
        h = r + q * s
        k = int(np.argmax(h))
        return float(h[k]), float(s[k])

    a = b = float(np.clip(0.0, low, high))
    value, slope = look(a)
    if value < 0.0 or slope == 0.0:
        return a
    step = unit if slope < 0.0 else -unit
    while True:
        b = float(np.clip(b + step, low, high))
        value, slope = look(b)
        if value < 0.0 or slope * step >= 0.0:
            break
        if b in (low, high) or abs(b) > WIDEST * unit:
            return b
        a, step = b, 2.0 * step
    if value < 0.0:
        return b
    for _ in range(HALVINGS):
        middle = 0.5 * (a + b)
        value, slope = look(middle)
        if value < 0.0 or slope == 0.0 or middle in (a, b):
            return middle
        if slope * step < 0.0:
            a = middle
        else:
            b = middle
    return 0.5 * (a + b)


def _between(w: np.ndarray, h: np.ndarray) -> np.ndarray:
    """Points on both sides of every maximum that comes near the largest."""
    inner = np.arange(1, len(w) - 1)
    tops = inner[(h[inner] >= h[inner - 1]) & (h[inner] >= h[inner + 1])]
    span = float(h.max() - np.median(h)) + 1e-300
    tops = tops[h[tops] > h.max() - 0.1 * span]
    tops = np.unique(np.append(tops[np.argsort(-h[tops])][:40], int(np.argmax(h))))
    found = [np.zeros(0)]
    for k in tops:
        for i, j in ((max(k - 1, 0), k), (k, min(k + 1, len(w) - 1))):
            if w[j] > w[i]:
                found.append(w[i] + (w[j] - w[i]) * np.array([0.1, 0.25, 0.5, 0.75, 0.9]))
    return np.setdiff1d(np.concatenate(found), w)


def highest(f: Callable[[np.ndarray], np.ndarray], w: np.ndarray) -> tuple[float, float]:
    """The largest value of a function on a refined grid, and its frequency."""
    found = best(lambda x: (f(x), np.zeros(len(x))), w, 0.0, 0.0, 0.0, 1.0)
    return found.m, found.at


def limit_of(k1: float, m: float) -> float:
    """``k1 + 1/m``; infinite where ``m`` is not positive."""
    return k1 + 1.0 / m if m > 0.0 else math.inf


def outcome(
    asked: Question, found: Best, which: str, multiplier: float | None, data: dict[str, Any], drawing: str
) -> Certificate:
    """The certificate. ``which`` says for which nonlinearities, as the end of a sentence after the sector."""
    limit = limit_of(asked.k1, found.m)
    capped = min(limit, asked.nyquist)
    upper = capped if asked.k2 is None else asked.k2
    proved = upper < capped if asked.k2 is not None else True
    warnings = list(asked.warnings)
    if not found.settled:
        warnings.append("The tightest frequency was not bracketed: the limit may be a little too large.")
    if asked.k2 is not None and proved and capped < 1.02 * asked.k2:
        warnings.append(
            f"The limit of {number(capped)} leaves {100 * (capped / asked.k2 - 1):.1f} % of reserve in the gain."
        )
    bound = "" if math.isinf(upper) else f" {'<=' if asked.k2 is not None else '<'} {upper:.4g}"
    if proved:
        statement = (
            f"The error dies out from every initial state for every nonlinearity with {asked.lower} phi(e)/e{bound}"
            f"{which}, while command and load stand at zero."
        )
    else:
        statement = (
            f"Not proved: the criterion reaches {number(capped)}, the sector asked for {asked.k2:.4g}; the loop may be "
            f"stable all the same, the Nyquist limit being {number(asked.nyquist)}."
        )
    grid = Grid(found.w, asked.grid.chosen, found.added)
    return Certificate(
        asked.criterion,
        "grid-checked" if proved else "refused",
        statement,
        of_loop(asked.loop),
        asked.sector,
        capped,
        None if asked.k2 is None else capped / asked.k2,
        multiplier,
        {**grid.as_dict(), "points": len(found.w) - found.added, "tightest": found.at},
        warnings,
        {"nyquist_limit": asked.nyquist, "tightest_rad_s": found.at, "m": found.m, "k1": asked.k1, **data},
        drawing,
    )
