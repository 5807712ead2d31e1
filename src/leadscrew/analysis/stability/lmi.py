"""Certificates: linear matrix inequalities solved by a Riccati equation and verified in exact arithmetic.

A condition that holds on a grid of frequencies says nothing about the frequencies between. The same condition as a
matrix inequality (the Kalman-Yakubovich-Popov lemma) is a proof: a function of the loop's state that falls in every
period. :mod:`leadscrew.analysis.stability.exact` verifies them without rounding. What is proved is about the loop whose
matrices are the doubles that were computed, and about every loop near it: the certificate says how near, and that this
is more than the rounding of the matrices.

======================  ====================================================================================
:func:`prove`           a criterion for a sector: circle, Tsypkin, Jury-Lee, Zames-Falb, Popov
:func:`largest_proved`  the largest sector that circle, Tsypkin, Jury-Lee or Popov proves
:func:`driven`          circle criterion on the slope: the loop under every command and load
======================  ====================================================================================

A sampled loop has its delays among its states. A continuous loop with a dead time has no finite state: it is refused.

The matrix inequalities of the stability criteria, and the search for their solution by a Riccati equation.

The loop ``x+ = a x + b v, e = -(c x + d v)`` with ``v = phi(e)`` (or ``x' = ...``) is stable if a function
``V = x' P x`` (plus an integral of ``phi`` for the criteria with a multiplier) falls along every motion. Each
inequality below is ``V``'s change plus what the sector makes positive, as a quadratic form of state and ``v``; ``w = v
- k1 e`` and ``k = k2 - k1``:

==========  ===================================================================  ======================================
criterion   what is added, positive in the sector                                holds for
==========  ===================================================================  ======================================
circle      ``2 w (k e - w)``                                                    gains that vary, and every static map
Tsypkin     ``+ 2 k q w (g - g_last)``, ``g = e - w / m``                        static maps of slope in [k1, k1 + m]
Jury-Lee    ``+ k q (2 w (e_next - e) + m (e_next - e)^2)``                      static maps of slope up to k1 + m
Popov       ``+ 2 k q w de/dt`` (continuous)                                     static maps
==========  ===================================================================  ======================================

For Tsypkin ``m`` may be infinite (``g = e``): any map whose slope is at least ``k1``. A negative ``q`` stands for the
multiplier that looks the other way: Tsypkin's ``2 k |q| w_last (g_last - g)``, Jury and Lee's with ``e_last`` for
``e_next``; the integral of ``w`` then counts against ``V``, and ``P`` must make up for it. Without the multiplier the
first row alone is the discrete or continuous Kalman-Yakubovich-Popov inequality of the circle criterion.

Sources: Ya. Z. Tsypkin, *Doklady* 145, 1962; E. I. Jury, B. W. Lee, *IEEE Trans. Automatic Control* 9, 1964, and in
state space W. M. Haddad, D. S. Bernstein, *Int. J. Robust and Nonlinear Control* 4, 1994; H. K. Khalil, *Nonlinear
Systems*, 3rd ed., Prentice Hall 2002, section 7.1; the Riccati equation: J. C. Willems, *IEEE Trans. Automatic
Control* 16, 1971; the multipliers of negative ``q``: R. O'Shea, M. I. Younis, *ibid.* 12, 1967.

The Zames-Falb criterion as a verified matrix inequality: fixed odd laws of bounded slope, sampled loops.

The multiplier ``1 + M(z)`` of :mod:`leadscrew.analysis.stability.criteria`, found on a grid of frequencies, remembers
the last errors; they become states. With ``w = v - k1 e``, ``g = e - w / s``, ``s = s2 - k1`` and ``k = k2 - k1``, what
is added to the circle's ``2 w (k e - w)`` is, for the coefficients of the delay ``i``::

    2 k q_i w (g - g_i),     2 k p_i w (g + g_i)           the delayed signal against the present w,
    2 k q_-i w_i (g_i - g),  2 k p_-i w_i (g_i + g)        the present signal against the delayed w

The second row makes ``x' P x`` no Lyapunov function, and ``P`` need not be positive: the inequality is the
Kalman-Yakubovich-Popov form of the frequency condition, and proves it at **every** frequency. That the condition makes
the loop stable is the theorem of Zames and Falb (R. O'Shea, M. I. Younis, IEEE Trans. Automatic Control 12, 1967;
J. C. Willems, R. W. Brockett, *ibid.* 13, 1968), which asks that the loop closed with ``k1`` is stable: that is proved
beside it.
"""

from __future__ import annotations

import math
import warnings
from fractions import Fraction
from typing import Any, Literal

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate, Grade, interval, of_loop
from leadscrew.analysis.stability.criteria import CRITERIA, Name, ask, jury_lee_lines, popov_lines, tsypkin_lines
from leadscrew.analysis.stability.exact import Inequality, Proof, proved, rational
from leadscrew.analysis.stability.linear import LinearLoop, own_grid
from leadscrew.analysis.stability.multiplier import best_multiplier, limit_of
from leadscrew.util.errors import ValueRefused

ROUNDING = 2.0**-42
"""Rounding of a loop's matrices that a proof must cover, of each entry: a thousand roundings of double precision."""

STRICTNESS = tuple(10.0**-k for k in range(2, 14))
"""By how much the Riccati equation is made strict, in parts of the sector's own weight: the largest that solves is
best."""


def inequality(loop: LinearLoop, k1: float, k2: float) -> Inequality:
    """The circle criterion's, for the sector ``[k1, k2]``."""
    e, v = _signals(loop)
    z, y = rational(np.hstack([loop.a, loop.b])), np.vstack([e, v])
    return Inequality(z, y, _sector(k1, k2, 2), loop.sampled, abs(z), np.vstack([abs(e), 0 * v]))


def tsypkin_inequality(loop: LinearLoop, k1: float, k2: float, q: float, slope: float = math.inf) -> Inequality:
    """Tsypkin's with the multiplier ``1 + q (1 - 1/z)`` or ``1 + |q| (1 - z)``: maps of slope in ``[k1, slope]``."""
    z, y, bounds, floor = _remembering(loop, k2 - k1, min(q, 0.0))
    low, k = Fraction(k1), Fraction(k2) - Fraction(k1)
    inverse = Fraction(0) if math.isinf(slope) else 1 / (Fraction(slope) - low)
    w, w_last = _vector(-low, 1, 0, 0), _vector(0, 0, -low, 1)
    step = _vector(1, 0, -1, 0) - inverse * (w - w_last)
    more = _product(w, step) if q >= 0.0 else _product(w_last, -step)
    return Inequality(z, y, _sector(k1, k2, 4) + k * abs(Fraction(q)) * more, True, *bounds, floor)


def jury_lee_inequality(loop: LinearLoop, k1: float, k2: float, q: float, slope: float) -> Inequality:
    """Jury and Lee's with the multiplier ``1 + q (z - 1)`` or ``1 + |q| (1/z - 1)``, for maps of slope up to ``slope``.

    Needs a loop without direct feed-through where ``q > 0``.
    """
    low, k, part = Fraction(k1), Fraction(k2) - Fraction(k1), abs(Fraction(q))
    curved = (Fraction(slope) - low) / 2
    if q < 0.0:
        z, y, bounds, floor = _remembering(loop, k2 - k1, q)
        w, step = _vector(-low, 1, 0, 0), _vector(-1, 0, 1, 0)
    else:
        e, v = _signals(loop)
        z = rational(np.hstack([loop.a, loop.b]))
        y = np.vstack([e, v, e[:-1].dot(z)])
        bounds, floor = (abs(z), np.vstack([abs(e), 0 * v, 3 * abs(e[:-1]).dot(abs(z))])), None
        w, step = _vector(-low, 1, 0), _vector(-1, 0, 1)
    s = _sector(k1, k2, len(y)) + k * part * (_product(w, step) + curved * _product(step, step))
    return Inequality(z, y, s, True, *bounds, floor)


def _remembering(
    loop: LinearLoop, k: float, q: float
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray], Any]:
    """The loop with the last ``e`` and ``v`` as states: z, rows of ``e, v, e_last, v_last``, bounds, floor."""
    n = len(loop.a)
    e, v = (np.concatenate([row[:n], rational(np.zeros(2)), row[n:]]) for row in _signals(loop))
    z = np.vstack([_wide(rational(np.hstack([loop.a, loop.b])), n, 2), e, v])
    e_last, v_last = rational(np.eye(n + 3)[n]), rational(np.eye(n + 3)[n + 1])
    bounds = np.vstack([abs(z[:n]), abs(e), 0 * v]), np.vstack([abs(e), 0 * v, 0 * v, 0 * v])
    return z, np.vstack([e, v, e_last, v_last]), bounds, _floor(e_last, n + 2, Fraction(k), Fraction(q))


def popov_inequality(loop: LinearLoop, k1: float, k2: float, q: float) -> Inequality:
    """Popov's with the multiplier ``1 + q s``, either sign of ``q``, for a continuous loop without feed-through."""
    n = len(loop.a)
    e, v = _signals(loop)
    z = rational(np.hstack([loop.a, loop.b]))
    y = np.vstack([e, v, e[:n].dot(z)])
    y_bound = np.vstack([abs(e), 0 * v, 3 * abs(e[:n]).dot(abs(z))])
    low, k, part = Fraction(k1), Fraction(k2) - Fraction(k1), Fraction(q)
    s = _sector(k1, k2, 3) + k * part * _product(_vector(-low, 1, 0), _vector(0, 0, 1))
    return Inequality(z, y, s, False, abs(z), y_bound, _floor(e, n, k, part))


def solve(lmi: Inequality, k1: float, least: float = ROUNDING, positive: bool = True) -> Proof | None:
    """A verified solution with a tolerance of at least ``least``; ``None`` where none is found.

    The Riccati equation that belongs to the inequality, made strict by a little, is solved with states scaled by how
    far noise at ``v`` moves them while ``v = k1 e``; what it gives is only a proposal, :func:`proved` decides.
    """
    scale = _state_sizes(lmi, k1)
    if scale is None:
        return None
    n = lmi.order
    z, y = lmi.z.astype(float), lmi.y.astype(float)
    grown = np.append(scale, 1.0)
    a, b = z[:, :n] / scale[:, None] * scale, z[:, n:] / scale[:, None]
    weights = (y * grown).T @ lmi.s.astype(float) @ (y * grown)
    size = float(np.abs(np.diag(weights)).max())

    def proposal(strict: float) -> np.ndarray | None:
        q = -(weights[:n, :n] + strict * size * np.eye(n))
        x = _riccati(lmi.sampled, a, b, q, -weights[n:, n:], -weights[:n, n:])
        return None if x is None else -x

    if proposal(STRICTNESS[-1]) is None:
        return None
    for strict in STRICTNESS:
        p = proposal(strict)
        if p is None or _hopeless(lmi.sampled, a, b, weights, p):
            continue
        proof = proved(lmi, p / scale[:, None] / scale, least, positive)
        if proof is not None:
            return proof
    return None


def _hopeless(sampled: bool, a: np.ndarray, b: np.ndarray, weights: np.ndarray, p: np.ndarray) -> bool:
    """Whether a proposal fails by far more than rounding, so that the exact look can be spared."""
    n = len(a)
    z, j = np.hstack([a, b]), np.eye(n, n + 1)
    minus = -weights - (z.T @ p @ z - j.T @ p @ j if sampled else z.T @ p @ j + j.T @ p @ z)
    diagonal = np.diag(minus)
    if not np.isfinite(minus).all() or (diagonal <= 0.0).any():
        return True
    unit = minus / np.sqrt(diagonal) / np.sqrt(diagonal)[:, None]
    return bool(np.linalg.eigvalsh(0.5 * (unit + unit.T))[0] < -1e-4)


def _riccati(sampled: bool, a: Any, b: Any, q: Any, r: Any, s: Any) -> np.ndarray | None:
    from scipy.linalg import LinAlgError, solve_continuous_are, solve_discrete_are

    solver = solve_discrete_are if sampled else solve_continuous_are
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return np.asarray(solver(a, b, q, r, s=s))
        except (LinAlgError, ValueError):
            return None


def _state_sizes(lmi: Inequality, k1: float) -> np.ndarray | None:
    """Standard deviation of every state under white noise at ``v``, powers of two; ``None`` where it grows."""
    from scipy.linalg import LinAlgError, matrix_balance, solve_continuous_lyapunov, solve_discrete_lyapunov

    n = lmi.order
    z, e = lmi.z.astype(float), lmi.y[0].astype(float)
    through = 1.0 - k1 * e[n]
    if through <= 0.0:
        return None
    a, b = z[:, :n] + k1 / through * np.outer(z[:, n], e[:n]), z[:, n:] / through
    poles = np.linalg.eigvals(a)
    if (np.abs(poles) >= 1.0).any() if lmi.sampled else (poles.real >= 0.0).any():
        return None
    a, (rough, _) = matrix_balance(a, permute=False, separate=True)
    b = b / rough[:, None]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            square = solve_discrete_lyapunov(a, b @ b.T) if lmi.sampled else solve_continuous_lyapunov(a, -b @ b.T)
        except (LinAlgError, ValueError):
            return None
    sizes = np.sqrt(np.maximum(np.diag(square), 0.0))
    top = float(sizes.max())
    if not np.isfinite(top) or top == 0.0:
        return None
    return np.asarray(2.0 ** np.round(np.log2(np.maximum(sizes, 1e-9 * top))) * rough)


def _signals(loop: LinearLoop) -> tuple[np.ndarray, np.ndarray]:
    """Rows of ``e`` and ``v`` over state and ``v``."""
    e = -rational(np.concatenate([loop.c.ravel(), loop.d.ravel()]))
    return e, rational(np.eye(len(e))[-1])


def _sector(k1: float, k2: float, signals: int) -> np.ndarray:
    """``2 (v - k1 e)(k2 e - v)`` over ``e, v, ...``."""
    rest = [0] * (signals - 2)
    return _product(_vector(-Fraction(k1), 1, *rest), _vector(Fraction(k2), -1, *rest))


def _vector(*entries: Fraction | int) -> np.ndarray:
    return np.array([Fraction(x) for x in entries], dtype=object)


def _product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The symmetric matrix of ``2 left right``."""
    return np.asarray(np.outer(left, right) + np.outer(right, left))


def _wide(z: np.ndarray, at: int, more: int) -> np.ndarray:
    return np.asarray(np.hstack([z[:, :at], rational(np.zeros((len(z), more))), z[:, at:]]))


def _floor(e: np.ndarray, n: int, k: Fraction, q: Fraction) -> np.ndarray | None:
    """Where ``q < 0`` the integral of ``w`` counts against ``V``: at most ``k e^2 / 2``, weighed with ``2 k |q|``."""
    return None if q >= 0 else np.asarray(-q * k * k * np.outer(e[:n], e[:n]))


Form = Literal["circle", "tsypkin", "jury-lee", "popov"]
Slopes = tuple[float, float] | None

SHORT = (1e-5, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3)
"""How far below the limit on the grid a proof is tried, in parts of ``k2 - k1``, nearest first."""

LARGEST = 1e6
"""Largest upper bound of a sector that is tried."""

LAWS = {
    "circle": "every error law between {0} e and {1} e, also one whose gain changes with time",
    "tsypkin": "every fixed error law between {0} e and {1} e{2}",
    "jury-lee": "every fixed error law between {0} e and {1} e{2}",
    "popov": "every fixed error law between {0} e and {1} e",
}


def prove(
    criterion: Name | Literal["best"], loop: LinearLoop, k1: float, k2: float, slopes: Slopes = None,
    *, taps: int | None = None,
) -> Certificate:  # fmt: skip
    """A criterion for the sector ``[k1, k2]`` as a verified matrix inequality.

    Args:
        criterion: a name of :data:`~leadscrew.analysis.stability.criteria.CRITERIA`, or ``best``: Tsypkin or Jury-Lee,
            whichever proves more on a grid of frequencies. The multiplier too is the grid's best; the proof is the
            inequality.
        loop: cut at the error, without a dead time; sampled, for Popov continuous, for the circle either.
        k1: lower bound of the sector.
        k2: upper bound.
        slopes: bounds of the map's slope; ``None``: it is at least ``k1``, which is all that Tsypkin needs and too
            little for Jury-Lee and Zames-Falb.
        taps: delays of Zames-Falb's multiplier to either side: 6 where not given.

    Raises:
        ValueRefused: bounds not finite or not in order, slopes that the criterion does not allow, a loop of the other
            kind.
    """
    row = CRITERIA["tsypkin" if criterion == "best" else criterion]
    kind, other = ("sampled", "best") if loop.sampled else ("continuous", "popov")
    if row.loops not in ("both", kind):
        raise ValueRefused(f"{criterion} is for {row.loops} loops, and {loop.name!r} is {kind}; use {other}")
    if taps is not None and "taps" not in row.options:
        raise ValueRefused(f"{criterion}: it has no taps")
    if criterion == "zames-falb":
        return _zames_falb(loop, k1, k2, slopes, TAPS if taps is None else taps)
    return _by_form(loop, k1, k2, _better(loop, k1, slopes) if criterion == "best" else criterion, slopes)


def largest_proved(
    loop: LinearLoop, k1: float, form: Form | Literal["best"] = "circle", slopes: Slopes = None
) -> Certificate:
    """The largest ``k2`` for which the sector ``[k1, k2]`` is proved, found from the limit on the grid downwards.

    ``limit`` of the certificate is that ``k2``; ``data["grid_limit"]`` what a grid of frequencies gives. With
    ``slopes`` it is at most their upper bound, which no such map exceeds; without, 1e6 stands for a sector without end.

    Raises:
        ValueRefused: as :func:`prove`.
    """
    chosen: Form = _better(loop, k1, slopes) if form == "best" else form
    refused = refusal(loop, k1)
    if refused is not None:
        return _of_form(loop, (k1, math.inf), chosen, "refused", refused)
    bound, q = grid_limit(loop, k1, chosen, slopes)
    top = min(bound, LARGEST if slopes is None else slopes[1])
    for short in SHORT:
        k2 = k1 + (top - k1) * (1.0 - short)
        proof = _prove(loop, k1, k2, chosen, q, slopes)
        if proof is not None:
            statement = _proved(loop, k1, k2, chosen, slopes, proof)
            numbers = {"grid_limit": bound, **_numbers(proof)}
            return _of_form(loop, (k1, math.inf), chosen, "certificate", statement, k2, q, numbers)
    statement = f"No sector that begins at {k1:g} is proved for {loop.name!r}."
    return _of_form(loop, (k1, math.inf), chosen, "refused", statement)


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
    gap = math.inf if slopes is None else slopes[1] - k1
    best, q = float(-g.real.min()), 0.0
    if best * gap < 1.0 and slopes is not None:
        return limit_of(k1, best), q  # no map of these slopes needs a multiplier
    z = np.exp(1j * w * (loop.dt or 0.0))
    lines = {
        "circle": [],
        "tsypkin": [(sign, *tsypkin_lines(g, z, sign, gap)) for sign in (1.0, -1.0)],
        "jury-lee": [(sign, *jury_lee_lines(g, z, sign, gap)) for sign in (1.0, -1.0)] if slopes is not None else [],
        "popov": [(sign, r, sign * s) for r, s in [popov_lines(g, w)] for sign in (1.0, -1.0)],
    }[form]
    for sign, r, s in lines:
        size = best_multiplier(r, s, 0.0, math.inf, 1.0 if loop.sampled else 1e-3)
        m = float((r + size * s).max())
        if m < best:
            best, q = m, sign * size
    return limit_of(k1, best), q


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
            f"loop {loop.name!r} feeds through directly: {CRITERIA[form].title} needs a loop without feed-through"
        )
    if form != "circle" and k1 == k2:
        raise ValueRefused(f"sector [{k1:g}, {k2:g}]: a multiplier needs k1 < k2; take circle for a fixed gain")


def refusal(loop: LinearLoop, k1: float) -> str | None:
    """Why no proof can exist, in a sentence; ``None`` where one can."""
    if loop.dead_time:
        return (
            f"{loop.name!r} is continuous with a dead time of {1e3 * loop.dead_time:g} ms: it has no finite state, "
            "and a matrix inequality none of its size; prove the sampled loop instead, whose delays are exact states "
            "(sampled_loop)."
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


def _by_form(loop: LinearLoop, k1: float, k2: float, form: Form, slopes: Slopes) -> Certificate:
    _checked(loop, k1, k2, form, slopes)
    refused = refusal(loop, k1)
    if refused is not None:
        return _of_form(loop, (k1, k2), form, "refused", refused)
    bound, q = grid_limit(loop, k1, form, slopes)
    proof = _prove(loop, k1, k2, form, q, slopes) if k2 <= bound else None
    if proof is not None:
        numbers = {"grid_limit": bound, **_numbers(proof)}
        return _of_form(loop, (k1, k2), form, "certificate", _proved(loop, k1, k2, form, slopes, proof), k2, q, numbers)
    if k2 < bound:
        statement = (
            f"On a grid of frequencies the {CRITERIA[form].title} criterion holds up to {bound:.6g}, but no matrix "
            f"inequality with a tolerance above rounding was found for {interval(k1, k2)}: it lies within rounding of "
            "the limit."
        )
        return _of_form(loop, (k1, k2), form, "grid-checked", statement, bound, q)
    nyquist = loop.gain_limit(k1)
    beyond = (
        f"a fixed gain of {nyquist:.4g} makes it unstable" if k2 >= nyquist
        else f"the Nyquist limit of {nyquist:.4g} alone does not settle it"
    )  # fmt: skip
    statement = (
        f"The {CRITERIA[form].title} criterion proves {loop.name!r} for {interval(k1, bound)}, not up to {k2:g}; "
        f"{beyond}."
    )
    return _of_form(loop, (k1, k2), form, "refused", statement, bound, q)


def _proved(loop: LinearLoop, k1: float, k2: float, form: Form, slopes: Slopes, proof: Proof) -> str:
    steep = ""
    if form == "tsypkin":
        steep = f" with a slope of at least {k1:g}" if slopes is None else f" with slopes in {interval(k1, slopes[1])}"
    elif form == "jury-lee" and slopes is not None:
        steep = f" with slopes up to {slopes[1]:g}"
    law = LAWS[form].format(f"{k1:g}", f"{k2:.6g}", steep)
    return (
        f"At rest, with {law}, {loop.name!r} returns to rest from every state, exponentially: proved "
        f"{_exactly(proof.tolerance)}."
    )


def _exactly(tolerance: float) -> str:
    return (
        "in exact arithmetic for its matrices in double precision, and for all that differ from them by up to "
        f"{tolerance:.2g} of each entry; their rounding is below {ROUNDING:.2g}"
    )


def _numbers(proof: Proof) -> dict[str, object]:
    return {"p": proof.p, "order": proof.order, "tolerance": proof.tolerance, "rounding": ROUNDING}


def _of_form(
    loop: LinearLoop, sector: tuple[float, float], form: Form, grade: Grade, statement: str,
    limit: float | None = None, q: float = 0.0, numbers: dict[str, object] | None = None,
) -> Certificate:  # fmt: skip
    title = f"{CRITERIA[form].title}, matrix inequality"
    multiplier = None if form == "circle" else q
    numbers = {"form": form, **(numbers or {})}
    return _certificate(loop, title, sector, grade, statement, limit, numbers, multiplier=multiplier)


def _certificate(
    loop: LinearLoop, title: str, sector: tuple[float, float], grade: Grade, statement: str, limit: float | None,
    numbers: dict[str, object], **more: Any,
) -> Certificate:  # fmt: skip
    upper = sector[1]
    margin = None if limit is None or not math.isfinite(upper) or upper <= 0.0 else limit / upper
    more.setdefault("warnings", list(loop.notes))
    return Certificate(title, grade, statement, of_loop(loop), sector, limit, margin, data=numbers, **more)


TAPS = 6
"""Delays of the multiplier to either side; on the loop L* of the XY table fewer gain nothing over one."""
SMALLEST = 1e-9
"""Coefficients below this part of the largest are left out."""


def _zames_falb(loop: LinearLoop, k1: float, k2: float, slopes: Slopes, taps: int) -> Certificate:
    """The sector ``[k1, k2]`` for every fixed odd law whose slope lies in ``slopes``."""
    if slopes is None or not (math.isfinite(slopes[1]) and k1 <= slopes[0] and k1 < k2 <= slopes[1]):
        raise ValueRefused(
            f"sector [{k1!r}, {k2!r}], slopes {slopes!r}: Zames-Falb needs k1 < k2 within the slopes, all finite"
        )
    slope = slopes[1]
    title, sector = "Zames-Falb, matrix inequality", (k1, k2)
    refused = refusal(loop, k1)
    if refused is not None:
        return _certificate(loop, title, sector, "refused", refused, None, {})
    on_grid = ask("zames-falb", loop, k1, slope=slope, taps=taps)
    limit = on_grid.limit if on_grid.limit is not None else k1
    weights = np.asarray(on_grid.data.get("weights", np.zeros(4 * taps)))
    numbers: dict[str, object] = {"grid_limit": limit, "taps": taps, "weights": weights}
    rest = solve(inequality(loop, k1, k1), k1)
    lmi = zames_falb_inequality(loop, k1, k2, weights, taps, slope)
    proof = solve(lmi, k1, positive=False) if k2 <= limit else None
    if proof is None or rest is None:
        statement = f"No proof of [{k1:g}, {k2:g}] for {loop.name!r}: on a grid the criterion holds up to {limit:.5g}."
        return _certificate(loop, title, sector, "refused", statement, limit, numbers)
    tolerance = min(proof.tolerance, rest.tolerance)
    law = f"between {k1:g} e and {k2:.6g} e with slopes in [{k1:g}, {slope:.6g}]"
    statement = (
        f"At rest, with every fixed odd error law {law}, {loop.name!r} returns to rest from every state: the condition "
        f"of Zames and Falb is proved at every frequency, {_exactly(tolerance)}."
    )
    numbers |= {**_numbers(proof), "tolerance": tolerance}
    return _certificate(loop, title, sector, "certificate", statement, k2, numbers)


def zames_falb_inequality(
    loop: LinearLoop, k1: float, k2: float, weights: np.ndarray, taps: int, slope: float
) -> Inequality:
    """The inequality for the coefficients ``q`` then ``p``, each for the delays ``-taps .. -1, 1 .. taps``."""
    used = np.where(weights > SMALLEST * max(float(weights.max()), SMALLEST), weights, 0.0)
    delays = [i for i in range(-taps, taps + 1) if i]
    most = max(
        (abs(i) for i, q, p in zip(delays, used[: 2 * taps], used[2 * taps :], strict=True) if q or p), default=1
    )
    n = len(loop.a)
    order = n + 2 * most
    e = rational(np.zeros(order + 1))
    e[:n], e[order] = -rational(loop.c.ravel()), -rational(loop.d)[0, 0]
    unit = rational(np.eye(order + 1))
    z = rational(np.zeros((order, order + 1)))
    z[:n, :n], z[:n, order] = rational(loop.a), rational(loop.b)[:, 0]
    first = n, n + most
    z[first[0]], z[first[1]] = e, unit[order]
    for start in first:
        for j in range(1, most):
            z[start + j] = unit[start + j - 1]
    y = np.vstack([e, unit[order], unit[n:order]])
    z_bound, y_bound = 0 * z, 0 * y
    z_bound[:n], z_bound[n], y_bound[0] = abs(z[:n]), abs(e), abs(e)
    low, k = Fraction(k1), Fraction(k2) - Fraction(k1)

    def signals(i: int) -> tuple[np.ndarray, np.ndarray]:
        """``w`` and ``g``, ``i`` periods ago, over ``y``."""
        error, law = np.array([Fraction(0)] * len(y), dtype=object), np.array([Fraction(0)] * len(y), dtype=object)
        error[0 if i == 0 else 1 + i] = Fraction(1)
        law[1 if i == 0 else 1 + most + i] = Fraction(1)
        w = law - low * error
        return w, error - w / (Fraction(slope) - low)

    error = np.array([Fraction(1)] + [Fraction(0)] * (len(y) - 1), dtype=object)
    (w, g), s = signals(0), np.outer(signals(0)[0], k * error - signals(0)[0])
    for sign, part in ((-1, used[: 2 * taps]), (1, used[2 * taps :])):
        for i, size in zip(delays, part, strict=True):
            if size == 0.0:
                continue
            w_then, g_then = signals(abs(i))
            more = np.outer(w, g + sign * g_then) if i > 0 else np.outer(w_then, g_then + sign * g)
            s = s + k * Fraction(float(size)) * more
    return Inequality(z, y, s + s.T, True, z_bound, y_bound)


CONVERGE = "every two motions of it under the same command and load converge, so no constant load makes a limit cycle"


def driven(loop: LinearLoop, slopes: tuple[float, float], factor: float = 1.0) -> Certificate:
    """The incremental circle criterion: the loop under every command and load, for slopes of the error law in
    ``slopes``.

    Two motions of ``e = r - G phi(e) - (load)`` under the same command and load differ by a motion of

        d = -G (phi(e + d) - phi(e)),          s1 <= (phi(e + d) - phi(e)) / d <= s2

    whatever ``e`` is: a loop with a gain that varies between the bounds of the slope. The circle criterion for
    ``[s1, s2]`` proves that ``d`` dies out: every two motions converge, exponentially; under any constant load there is
    one equilibrium, and no limit cycle; a periodic command gives one periodic error of the same period; bounded
    commands and loads give bounded errors. Criteria with a multiplier (Popov, Tsypkin, Jury-Lee) do not give this: they
    are about the loop at rest. Sources: V. Fromion, G. Scorletti, *Int. J. Robust and Nonlinear Control* 13, 2003; G.
    Zames, *IEEE Trans. Automatic Control* 11, 1966.

    ``limit`` is the largest upper slope that is proved with the lower one kept; ``factor`` that by which it is to
    exceed ``slopes[1]`` (``m2`` of a design procedure). A proof by a matrix inequality makes it a certificate; a
    continuous loop with a dead time is checked on a grid of frequencies, with a warning that this is no proof.

    Raises:
        ValueRefused: slopes that are not finite or not in order, or a factor below 1.
    """
    s1, s2 = slopes
    if not (math.isfinite(s1) and math.isfinite(s2) and s1 <= s2):
        raise ValueRefused(f"slopes ({s1!r}, {s2!r}): needs finite bounds in order")
    if not (math.isfinite(factor) and factor >= 1.0):
        raise ValueRefused(f"factor = {factor!r}: on the steepest slope; allowed from 1")
    top = s1 + factor * (s2 - s1) if s1 == s2 else factor * s2
    numbers: dict[str, object] = {"asked": factor, "loop": loop}
    more: dict[str, Any] = {"drawing": "slopes"}
    law = f"With slopes of the error law in {interval(s1, top)}" if s1 != top else "Linear"

    def certificate(grade: Grade, statement: str, limit: float | None = None) -> Certificate:
        return _certificate(loop, "driven (incremental circle)", slopes, grade, statement, limit, numbers, **more)

    if loop.dead_time:
        more["grid"] = own_grid(loop).as_dict()
        more["warnings"] = [*loop.notes, (
            f"A frequency check, no proof: with a dead time of {1e3 * loop.dead_time:g} ms the continuous loop has no "
            "finite state; the sampled loop, whose delays are exact states, can be proved."
        )]  # fmt: skip
        if not loop.stable(s1):
            return certificate("refused", f"{loop.name!r} closed with the lower slope {s1:g} is not stable.")
        bound, _ = grid_limit(loop, s1, "circle")
        if top < bound:
            return certificate("grid-checked", f"{law}, {loop.name!r} under any command and load: {CONVERGE}.", bound)
        return certificate("refused", _too_steep(loop, s1, top, bound), bound)
    refused = refusal(loop, s1)
    if refused is not None:
        return certificate("refused", refused)
    bound, _ = grid_limit(loop, s1, "circle")
    numbers["grid_limit"] = bound
    limit = largest_proved(loop, s1).limit
    proof = solve(inequality(loop, s1, top), s1) if top <= bound else None
    if proof is None:
        return certificate("refused", _too_steep(loop, s1, top, limit or bound), limit)
    numbers |= _numbers(proof)
    statement = (
        f"{law}, {loop.name!r} is stable under every command and load: {CONVERGE}. Proved {_exactly(proof.tolerance)}."
    )
    return certificate("certificate", statement, max(top, limit or top))


def _too_steep(loop: LinearLoop, s1: float, top: float, limit: float) -> str:
    nyquist = loop.gain_limit(s1)
    beyond = (
        f"a load that holds it where the slope exceeds the Nyquist limit {nyquist:.4g} makes it swing" if top >= nyquist
        else f"up to the Nyquist limit of {nyquist:.4g} nothing is known either way"
    )  # fmt: skip
    return (
        f"{loop.name!r} is proved under command and load for slopes of the error law in {interval(s1, limit)}, not up "
        f"to {top:.4g}; {beyond}."
    )
