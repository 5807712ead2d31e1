"""Certificates: linear matrix inequalities solved by a Riccati equation and verified in exact arithmetic.

A condition that holds on a grid of frequencies says nothing about the frequencies between. The same condition as a
matrix inequality (the Kalman-Yakubovich-Popov lemma) is a proof: a function of the loop's state that falls in every
period. :mod:`leadscrew.analysis.stability.kyp` has the inequalities, :mod:`leadscrew.analysis.stability.exact` verifies
them without rounding. What is proved is about the loop whose matrices are the doubles that were computed, and about
every loop near it: the certificate says how near, and that this is more than the rounding of the matrices.

========================  ==================================================================================
:func:`lmi_circle`        circle criterion: gains that vary in time, and every map in the sector
:func:`lmi_tsypkin`       Tsypkin, or Jury and Lee: static maps with bounded slope, sampled loops
:func:`lmi_popov`         Popov: static maps, continuous loops without dead time
:func:`largest_proved`    the largest sector that one of them proves
========================  ==================================================================================

A sampled loop has its delays among its states. A continuous loop with a dead time has no finite state: it is refused.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate, Grade, interval, of_loop
from leadscrew.analysis.stability.exact import Proof
from leadscrew.analysis.stability.grid import own_grid
from leadscrew.analysis.stability.kyp import (
    ROUNDING,
    inequality,
    jury_lee_inequality,
    popov_inequality,
    solve,
    tsypkin_inequality,
)
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.kernel.errors import ValueRefused

Form = Literal["circle", "tsypkin", "jury-lee", "popov"]
Slopes = tuple[float, float] | None

SHORT = (1e-5, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3)
"""How far below the limit on the grid a proof is tried, in parts of ``k2 - k1``, nearest first."""

LARGEST = 1e6
"""Largest upper bound of a sector that is tried."""

WHO = {
    "circle": "every error law between {0} e and {1} e, also one whose gain changes with time",
    "tsypkin": "every fixed error law between {0} e and {1} e{2}",
    "jury-lee": "every fixed error law between {0} e and {1} e{2}",
    "popov": "every fixed error law between {0} e and {1} e",
}
NAMES = {"circle": "circle", "tsypkin": "Tsypkin", "jury-lee": "Jury-Lee", "popov": "Popov"}


def lmi_circle(loop: LinearLoop, k1: float, k2: float) -> Certificate:
    """The circle criterion for the sector ``[k1, k2]`` as a verified matrix inequality.

    Raises:
        ValueRefused: bounds that are not finite or not in order.
    """
    return _certificate(loop, k1, k2, "circle", None)


def lmi_tsypkin(
    loop: LinearLoop, k1: float, k2: float, slopes: Slopes = None, form: Literal["best", "tsypkin", "jury-lee"] = "best"
) -> Certificate:
    """Tsypkin's criterion, or Jury and Lee's, for the sector ``[k1, k2]`` as a verified matrix inequality.

    ``slopes`` bounds the slope of the map; ``None``: it is at least ``k1``, which is all that Tsypkin needs and too
    little for Jury and Lee. ``best`` takes the one that proves more on a grid of frequencies; its multiplier too is the
    grid's best, the proof is the inequality.

    Raises:
        ValueRefused: bounds not finite or not in order, a slope below ``k1`` for Tsypkin, no slopes for Jury-Lee, a
            continuous loop.
    """
    if not loop.sampled:
        raise ValueRefused(
            f"loop {loop.name!r} is continuous: Tsypkin and Jury-Lee are for sampled loops; use lmi_popov"
        )
    if form != "best":
        return _certificate(loop, k1, k2, form, slopes)
    return _certificate(loop, k1, k2, _better(loop, k1, slopes), slopes)


def lmi_popov(loop: LinearLoop, k1: float, k2: float) -> Certificate:
    """Popov's criterion for the sector ``[k1, k2]`` of a continuous loop as a verified matrix inequality.

    Raises:
        ValueRefused: bounds not finite or not in order, a sampled loop.
    """
    if loop.sampled:
        raise ValueRefused(f"loop {loop.name!r} is sampled: Popov is for continuous loops; use lmi_tsypkin")
    return _certificate(loop, k1, k2, "popov", None)


def largest_proved(
    loop: LinearLoop, k1: float, form: Form | Literal["best"] = "circle", slopes: Slopes = None
) -> Certificate:
    """The largest ``k2`` for which the sector ``[k1, k2]`` is proved, found from the limit on the grid downwards.

    ``limit`` of the certificate is that ``k2``; ``data["grid_limit"]`` what a grid of frequencies gives. With
    ``slopes`` it is at most their upper bound, which no such map exceeds; without, 1e6 stands for a sector without end.

    Raises:
        ValueRefused: as :func:`lmi_circle` and :func:`lmi_tsypkin`.
    """
    chosen: Form = _better(loop, k1, slopes) if form == "best" else form
    refused = refusal(loop, k1)
    if refused is not None:
        return _made(loop, (k1, math.inf), chosen, "refused", refused)
    bound, q = grid_limit(loop, k1, chosen, slopes)
    top = min(bound, LARGEST if slopes is None else slopes[1])
    for short in SHORT:
        k2 = k1 + (top - k1) * (1.0 - short)
        proof = _prove(loop, k1, k2, chosen, q, slopes)
        if proof is not None:
            return _proved(loop, k1, k2, chosen, q, slopes, proof, k2, bound, asked=(k1, math.inf))
    return _made(
        loop, (k1, math.inf), chosen, "refused", f"No sector that begins at {k1:g} is proved for {loop.name!r}."
    )


def grid_limit(loop: LinearLoop, k1: float, form: Form, slopes: Slopes = None) -> tuple[float, float]:
    """The largest ``k2`` on the loop's own grid of frequencies, and the multiplier ``q`` that gives it.

    With ``G1 = G / (1 + k1 G)``: ``k2 = k1 + 1 / m``, ``m = min over q of max over w of -Re[...]``, convex in ``q``.
    """
    w = own_grid(loop).w
    if loop.dead_time:
        g = loop.response(w)
        g = g / (1.0 + k1 * g)
    else:
        g = loop.shifted(k1).response(w)  # finite where an undamped resonator makes G infinite
    z = np.exp(1j * w * (loop.dt or 0.0))
    pieces: list[np.ndarray] = []
    if form == "tsypkin":
        inverse = 0.0 if slopes is None else 1.0 / (slopes[1] - k1)
        pieces = [((1.0 - 1.0 / z) * (g + inverse)).real, ((1.0 - z) * (g + inverse)).real]
    elif form == "jury-lee" and slopes is not None:
        curved = 0.5 * (slopes[1] - k1) * np.abs((z - 1.0) * g) ** 2
        pieces = [((z - 1.0) * g).real - curved, ((1.0 / z - 1.0) * g).real - curved]
    elif form == "popov":
        pieces = [-w * g.imag, w * g.imag]
    best, q = float(-g.real.min()), 0.0
    if slopes is not None and best * (slopes[1] - k1) < 1.0:
        return (k1 + 1.0 / best if best > 0.0 else math.inf), 0.0  # no map of these slopes needs a multiplier
    for sign, piece in zip((1.0, -1.0), pieces, strict=False):
        size, m = _least(g.real, piece, loop)
        if m < best:
            best, q = m, sign * size
    return (k1 + 1.0 / best if best > 0.0 else math.inf), q


def _least(real: np.ndarray, piece: np.ndarray, loop: LinearLoop) -> tuple[float, float]:
    """The size ``x`` with the least ``m = max -(real + x piece)``, and ``m``: over octaves, then refined."""
    from scipy.optimize import minimize_scalar

    def worst(x: float) -> float:
        return float(-(real + x * piece).min())

    unit = 1.0 if loop.sampled else 1e-3
    tried = unit * 2.0 ** np.arange(-14, 15)
    i = int(np.argmin([worst(float(x)) for x in tried]))
    low, high = math.log(tried[max(i - 1, 0)]), math.log(tried[min(i + 1, len(tried) - 1)])
    found = minimize_scalar(lambda x: worst(math.exp(x)), bounds=(low, high), method="bounded", options={"xatol": 1e-6})
    return math.exp(float(found.x)), float(found.fun)


def _better(loop: LinearLoop, k1: float, slopes: Slopes) -> Form:
    forms: list[Form] = []
    if slopes is None or slopes[0] >= k1:
        forms.append("tsypkin")
    if slopes is not None and float(loop.d[0, 0]) == 0.0:
        forms.append("jury-lee")
    if not forms:
        raise ValueRefused(
            f"slopes {slopes}: Tsypkin needs a slope of at least k1 = {k1:g}, Jury-Lee a loop with a delay"
        )
    return max(forms, key=lambda form: grid_limit(loop, k1, form, slopes)[0]) if refusal(loop, k1) is None else forms[0]


def _checked(loop: LinearLoop, k1: float, k2: float, form: Form, slopes: Slopes) -> None:
    if not (math.isfinite(k1) and math.isfinite(k2) and k1 <= k2):
        raise ValueRefused(
            f"sector [{k1!r}, {k2!r}]: needs finite bounds in order; for the largest take largest_proved"
        )
    if slopes is not None and not (math.isfinite(slopes[0]) and math.isfinite(slopes[1]) and slopes[0] < slopes[1]):
        raise ValueRefused(
            f"slopes {slopes}: needs finite bounds in order; leave them out where the slope has no limit"
        )
    if form == "tsypkin" and slopes is not None and slopes[0] < k1:
        raise ValueRefused(f"slopes from {slopes[0]:g}: Tsypkin needs a slope of at least k1 = {k1:g}; use Jury-Lee")
    if form == "jury-lee" and slopes is None:
        raise ValueRefused("Jury-Lee needs the bounds of the map's slope: slopes=(s1, s2)")
    if form in ("jury-lee", "popov") and float(loop.d[0, 0]) != 0.0:
        raise ValueRefused(
            f"loop {loop.name!r} feeds through directly: {NAMES[form]} needs a loop without feed-through"
        )
    if form != "circle" and k1 == k2:
        raise ValueRefused(f"sector [{k1:g}, {k2:g}]: a multiplier needs k1 < k2; take lmi_circle for a fixed gain")


def refusal(loop: LinearLoop, k1: float) -> str | None:
    """Why no proof can exist, in a sentence; ``None`` where one can."""
    if loop.dead_time:
        return (
            f"{loop.name!r} is continuous with a dead time of {1e3 * loop.dead_time:g} ms: it has no finite state, "
            "and a matrix inequality none of its size; prove the sampled loop instead, whose delays are exact states "
            "(sampled_loop, or table_i_sampled for the XY table: L_star)."
        )
    if not loop.stable(k1):
        worst = np.abs(loop.closed_poles(k1)).max() if loop.sampled else loop.closed_poles(k1).real.max()
        what = f"|z| = {worst:.9g}" if loop.sampled else f"Re s = {worst:.4g} 1/s"
        more = "; an integrator needs k1 > 0" if k1 == 0.0 else ""
        return (
            f"{loop.name!r} closed with the sector's lower bound {k1:g} is not asymptotically stable ({what}), so no "
            f"sector that holds it can be proved{more}."
        )
    return None


def _prove(loop: LinearLoop, k1: float, k2: float, form: Form, q: float, slopes: Slopes) -> Proof | None:
    if form == "circle" or q == 0.0:
        return solve(inequality(loop, k1, k2), k1)
    if form == "tsypkin":
        return solve(tsypkin_inequality(loop, k1, k2, q, math.inf if slopes is None else slopes[1]), k1)
    if form == "jury-lee" and slopes is not None:
        return solve(jury_lee_inequality(loop, k1, k2, q, slopes[1]), k1)
    return solve(popov_inequality(loop, k1, k2, q), k1)


def _certificate(loop: LinearLoop, k1: float, k2: float, form: Form, slopes: Slopes) -> Certificate:
    _checked(loop, k1, k2, form, slopes)
    refused = refusal(loop, k1)
    if refused is not None:
        return _made(loop, (k1, k2), form, "refused", refused)
    bound, q = grid_limit(loop, k1, form, slopes)
    proof = _prove(loop, k1, k2, form, q, slopes) if k2 <= bound else None
    if proof is not None:
        return _proved(loop, k1, k2, form, q, slopes, proof, k2, bound, asked=(k1, k2))
    if k2 < bound:
        said = (
            f"On a grid of frequencies the {NAMES[form]} criterion holds up to {bound:.6g}, but no matrix inequality "
            f"with a tolerance above rounding was found for {interval(k1, k2)}: it lies within rounding of the limit."
        )
        return _made(loop, (k1, k2), form, "grid-checked", said, bound, q)
    nyquist = loop.gain_limit(k1)
    beyond = (
        f"; a fixed gain of {nyquist:.4g} makes it unstable" if k2 >= nyquist
        else f"; the Nyquist limit of {nyquist:.4g} alone does not settle it"
    )  # fmt: skip
    said = f"The {NAMES[form]} criterion proves {loop.name!r} for {interval(k1, bound)}, not up to {k2:g}{beyond}."
    return _made(loop, (k1, k2), form, "refused", said, bound, q)


def _proved(
    loop: LinearLoop, k1: float, k2: float, form: Form, q: float, slopes: Slopes, proof: Proof, limit: float,
    bound: float, asked: tuple[float, float],
) -> Certificate:  # fmt: skip
    steep = ""
    if form == "tsypkin":
        steep = f" with a slope of at least {k1:g}" if slopes is None else f" with slopes in {interval(k1, slopes[1])}"
    elif form == "jury-lee" and slopes is not None:
        steep = f" with slopes up to {slopes[1]:g}"
    law = WHO[form].format(f"{k1:g}", f"{k2:.6g}", steep)
    said = (
        f"At rest, with {law}, {loop.name!r} returns to rest from every state, exponentially: proved in exact "
        f"arithmetic for its matrices in double precision, and for all that differ from them by up to "
        f"{proof.tolerance:.2g} of each entry; their rounding is below {ROUNDING:.2g}."
    )
    extra = {
        "grid_limit": bound,
        "p": proof.p,
        "order": proof.order,
        "tolerance": proof.tolerance,
        "rounding": ROUNDING,
    }
    return _made(loop, asked, form, "certificate", said, limit, q, extra)


def _made(
    loop: LinearLoop, sector: tuple[float, float], form: Form, grade: Grade, statement: str, limit: float | None = None,
    q: float = 0.0, extra: dict[str, object] | None = None,
) -> Certificate:  # fmt: skip
    asked = sector[1]
    margin = None if limit is None or not math.isfinite(asked) or asked == 0.0 else limit / asked
    return Certificate(
        f"{NAMES[form]}, matrix inequality", grade, statement, of_loop(loop), sector, limit, margin,
        None if form == "circle" else q, None, list(loop.notes), {"form": form, **(extra or {})},
    )  # fmt: skip
