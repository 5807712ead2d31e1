"""What is asked of a criterion: a loop, a sector, perhaps the nonlinearity itself; and why it may be refused."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate, interval, number, of_loop
from leadscrew.analysis.stability.grid import Grid, given_grid, own_grid
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.kernel.errors import ValueRefused

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

    def refused(self, sentence: str = "", data: dict[str, Any] | None = None, draw: Any = None) -> Certificate:
        """The certificate of a refusal."""
        return Certificate(
            self.criterion, "refused", sentence or self.refusal, of_loop(self.loop), self.sector,
            grid=self.grid.as_dict(), warnings=self.warnings, data=data or {}, draw=draw,
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
