"""From the best value of a frequency condition to the certificate of the sector that it proves."""

from __future__ import annotations

import math
from typing import Any

from leadscrew.analysis.stability.certificate import Certificate, number, of_loop
from leadscrew.analysis.stability.envelope import Best
from leadscrew.analysis.stability.grid import Grid
from leadscrew.analysis.stability.question import Question


def limit_of(k1: float, m: float) -> float:
    """``k1 + 1/m``; infinite where ``m`` is not positive."""
    return k1 + 1.0 / m if m > 0.0 else math.inf


def outcome(
    asked: Question, found: Best, which: str, multiplier: float | None, data: dict[str, Any], draw: Any
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
        draw,
    )
