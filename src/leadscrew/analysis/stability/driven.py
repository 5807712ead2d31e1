"""Stability of a loop that is driven: loads, following errors, any motion. The slope of the error law decides, not its
gain.

Two motions of ``e = r - G phi(e) - (load)`` under the same command and load differ by a motion of

    d = -G (phi(e + d) - phi(e)),          s1 <= (phi(e + d) - phi(e)) / d <= s2

whatever ``e`` is: a loop with a gain that varies between the bounds of the slope. The circle criterion for ``[s1, s2]``
proves that ``d`` dies out, so that (V. Fromion, G. Scorletti, *Int. J. Robust and Nonlinear Control* 13, 2003; G.
Zames, *IEEE Trans. Automatic Control* 11, 1966):

- every two motions converge, exponentially: what the loop does is forgotten;
- under any constant load there is one equilibrium, and it is reached: no limit cycle;
- a periodic command gives one periodic error of the same period: no subharmonics, no chatter;
- bounded commands and loads give bounded errors.

Criteria with a multiplier (Popov, Tsypkin, Jury-Lee) do not give this: they speak of the loop at rest.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from leadscrew.analysis.stability.certificate import Certificate, Grade, interval, of_loop
from leadscrew.analysis.stability.linear import LinearLoop, own_grid
from leadscrew.analysis.stability.lmi import ROUNDING, grid_limit, inequality, largest_proved, refusal, solve
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    pass

KEPT = "every two motions of it under the same command and load converge, so no constant load makes a limit cycle"


def driven(loop: LinearLoop, slopes: tuple[float, float], asked: float = 1.0) -> Certificate:
    """The incremental circle criterion: the loop under every command and load, for slopes of the error law in
    ``slopes``.

    ``limit`` is the largest upper slope that is proved with the lower one kept; ``asked`` the factor by which it is to
    exceed ``slopes[1]`` (``m2`` of a design procedure). A proof by a matrix inequality makes it a certificate; a
    continuous loop with a dead time is checked on a grid of frequencies, and says so.

    Raises:
        ValueRefused: slopes that are not finite or not in order, or a factor below 1.
    """
    s1, s2 = slopes
    if not (math.isfinite(s1) and math.isfinite(s2) and s1 <= s2):
        raise ValueRefused(f"slopes ({s1!r}, {s2!r}): needs finite bounds in order")
    if not (math.isfinite(asked) and asked >= 1.0):
        raise ValueRefused(f"asked = {asked!r}: the factor on the steepest slope; allowed from 1")
    if loop.dead_time:
        return _on_grid(loop, s1, s2, asked)
    refused = refusal(loop, s1)
    if refused is not None:
        return _certificate(loop, slopes, "refused", refused, None, None, {})
    top = s1 + asked * (s2 - s1) if s1 == s2 else asked * s2
    bound, _ = grid_limit(loop, s1, "circle")
    proof = solve(inequality(loop, s1, top), s1) if top <= bound else None
    best = largest_proved(loop, s1)
    limit = best.limit if best.limit is not None else None
    numbers: dict[str, object] = {"grid_limit": bound, "asked": asked}
    if proof is not None:
        law = f"With slopes of the error law in {interval(s1, top)}" if s1 != top else "Linear"
        said = (
            f"{law}, {loop.name!r} is stable under every command and load: {KEPT}. Proved in exact arithmetic for its "
            f"matrices in double precision, and for all that differ from them by up to {proof.tolerance:.2g} of each "
            f"entry; their rounding is below {ROUNDING:.2g}."
        )
        numbers |= {"p": proof.p, "order": proof.order, "tolerance": proof.tolerance, "rounding": ROUNDING}
        return _certificate(loop, slopes, "certificate", said, max(top, limit or top), None, numbers)
    return _certificate(loop, slopes, "refused", _too_steep(loop, s1, top, limit or bound), limit, None, numbers)


def _on_grid(loop: LinearLoop, s1: float, s2: float, asked: float) -> Certificate:
    """The criterion at the loop's own frequencies: no proof."""
    top, grid = asked * s2, own_grid(loop)
    why = (
        f"A frequency check, no proof: with a dead time of {1e3 * loop.dead_time:g} ms the continuous loop has no "
        "finite state; the sampled loop, whose delays are exact states, can be proved."
    )
    if not loop.stable(s1):
        said = (
            f"{loop.name!r} closed with the lower slope {s1:g} is not stable, so nothing can be said of steeper ones."
        )
        return _certificate(loop, (s1, s2), "refused", said, None, grid.as_dict(), {"asked": asked}, [why])
    bound, _ = grid_limit(loop, s1, "circle")
    if top < bound:
        said = f"With slopes of the error law in {interval(s1, top)}, {loop.name!r} under any command and load: {KEPT}."
        return _certificate(loop, (s1, s2), "grid-checked", said, bound, grid.as_dict(), {"asked": asked}, [why])
    said = _too_steep(loop, s1, top, bound)
    return _certificate(loop, (s1, s2), "refused", said, bound, grid.as_dict(), {"asked": asked}, [why])


def _too_steep(loop: LinearLoop, s1: float, top: float, limit: float) -> str:
    nyquist = loop.gain_limit(s1)
    proved = f"slopes of the error law in {interval(s1, limit)}, not up to {top:.4g}"
    said = f"{loop.name!r} is proved under command and load for {proved}"
    if top >= nyquist:
        return f"{said}; a load that holds it where the slope exceeds the Nyquist limit {nyquist:.4g} makes it swing."
    return f"{said}; up to the Nyquist limit of {nyquist:.4g} nothing is known either way."


def _certificate(
    loop: LinearLoop, slopes: tuple[float, float], grade: Grade, said: str, limit: float | None,
    grid: dict[str, float | int | bool] | None, numbers: dict[str, object], warnings: list[str] | None = None,
) -> Certificate:  # fmt: skip
    margin = None if limit is None or slopes[1] <= 0.0 else limit / slopes[1]
    return Certificate(
        "driven (incremental circle)", grade, said, of_loop(loop), slopes, limit, margin, None, grid,
        [*loop.notes, *(warnings or [])], numbers | {"loop": loop}, "slopes",
    )  # fmt: skip
