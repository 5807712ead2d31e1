"""The absolute-stability criteria: a table of what each needs and proves, and :func:`ask`, which asks one of them.

A loop ``e = -G phi(e)`` returns to rest from every state, for every ``phi`` with ``k1 <= phi(e)/e <= k2``, where at all
frequencies, with ``G1 = G / (1 + k1 G)`` stable and ``z = e^(jwT)``,

==========  ==================================================================================================
circle      ``Re G1 + 1/(k2 - k1) > 0``
Popov       ``Re[(1 + j w q) G1] + 1/(k2 - k1) > 0``, one real ``q``
Tsypkin     ``Re[(1 + q (1 - 1/z)) G1] + 1/(k2 - k1) > 0``; for ``q < 0`` ``z`` in place of ``1/z`` and ``-q``
Jury-Lee    ``Re[(1 + q (z - 1)) G1] - (q s/2) |(z - 1) G1|^2 + 1/(k2 - k1) > 0``, ``s = s2 - k1``; for ``q < 0`` so
Zames-Falb  ``Re[(1 + M) G1] + Re M / s + 1/(k2 - k1) > 0``,
            ``M = sum of q_i (1 - z^-i) + p_i (1 + z^-i)``, ``q_i, p_i >= 0``, ``i = -taps .. -1, 1 .. taps``
==========  ==================================================================================================

The largest ``k2`` is ``k1 + 1/m`` with ``m`` the smallest maximum of the negative left side over the multipliers.

Circle: in the Nyquist plane the curve of ``G`` keeps out of the circle over the diameter from ``-1/k1`` to ``-1/k2``.
On the sector of the *slope* it is a proof for the loop under load and on the move,
:func:`leadscrew.analysis.stability.lmi.driven`. G. Zames, IEEE Trans. Automatic Control 11 (1966) 465; sampled: Y. Z.
Tsypkin, Automation and Remote Control 24 (1963).

Popov: of continuous loops. A sampled one is replaced by its continuous model, of which alone something is proved then.
The limits of ``w Im G1`` at infinite frequency are part of the condition: with a dead time and one pole more than zeros
it never dies out. V. M. Popov, Automation and Remote Control 22 (1961) 857; both signs and any sector: M. A. Aizerman,
F. R. Gantmacher, *Absolute Stability of Regulator Systems*, Holden-Day 1964.

Tsypkin: for ``q >= 0`` the proof rests on ``F(e_k) - F(e_(k-1)) <= phi(e_k) (e_k - e_(k-1))`` with the convex
``F = integral of phi``: Y. Z. Tsypkin, *Automatika i Telemekhanika* 1964; in state space V. Kapila, W. M. Haddad, IEEE
Trans. Automatic Control 41 (1996) 149. For ``q < 0``: R. O'Shea, M. I. Younis, *ibid.* 12 (1967) 725.

Jury-Lee rests on ``phi(a)(b - a) >= F(b) - F(a) - s/2 (b - a)^2``: E. I. Jury, B. W. Lee, *ibid.* 9 (1964) 51.

Zames-Falb rests on ``sum_k f_k g_k >= |sum_k f_k g_(k-i)|`` for ``f`` an odd monotone function of ``g``: O'Shea and
Younis; J. C. Willems, R. W. Brockett, *ibid.* 13 (1968) 503. Tsypkin's is the case of one tap. The multiplier of most
reach is a linear program, solved on a few frequencies, checked on the grid, and solved again with the worst of those.
Its limit is the largest ``k2`` for slopes of at most ``max(s2, k2)``: beyond ``s2``, where no map of slope ``s2`` has
such a gain, the slope grows with the sector. It is then what the map may be multiplied by.

With an integrator and ``k1 = 0`` (the critical case) ``phi`` must not vanish and ``q >= 0``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate, interval, number, of_loop
from leadscrew.analysis.stability.linear import Grid, LinearLoop, given_grid, own_grid, worst_pole
from leadscrew.analysis.stability.loop import continuous_model
from leadscrew.analysis.stability.multiplier import ROUNDS, Best, best, limit_of
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.analysis.stability.lure import Lure

Name = Literal["circle", "tsypkin", "jury-lee", "zames-falb", "popov"]
Need = Literal["static", "monotone", "odd"]

SMALL_ERROR_MM = 0.01
"""Error at which a nonlinearity in a useful unit already does something."""
NOTHING = 1e-3
"""Share of its full effect below which it does nothing there."""
CONDITIONAL = (
    "The loop is stable with a gain of 1 but not with every smaller one, as strong integral action or resonators make "
    "it"
)


class Criterion(NamedTuple):
    """A row of the table."""

    title: str
    proves: str
    """For which nonlinearities, as the end of a sentence after the sector."""
    loops: Literal["both", "sampled", "continuous"]
    needs: tuple[Need, ...]
    """Properties of the nonlinearity."""
    options: tuple[str, ...]
    """Of :func:`ask`: ``q``, ``slope``, ``taps``."""
    search: Callable[[Problem], Search]
    """The best multiplier."""
    drawing: str = "condition"

    def lacks(self, law: Lure, k1: float) -> Need | None:
        """The first property that it needs and the nonlinearity does not have."""
        has = {
            "static": not law.dependent,
            "monotone": law.slope_sector is None or law.slope_sector[0] >= k1 - 1e-9,
            "odd": law.dependent or law.odd,
        }
        return next((need for need in self.needs if not has[need]), None)


@dataclass
class Problem:
    """A sector to prove for a loop, transformed so that the sector starts at 0: ``G1 = G / (1 + k1 G)``."""

    criterion: Criterion
    loop: LinearLoop
    k1: float
    k2: float | None
    grid: Grid
    nyquist: float
    """Largest gain above ``k1`` up to which the linear loop is stable."""
    critical: bool
    """Whether the transformed loop has a pole on its boundary: the integrator, with ``k1 = 0``."""
    q: float | None = None
    slope: float | None = None
    taps: int = 0
    warnings: list[str] = field(default_factory=list)
    cached: np.ndarray | None = field(default=None, repr=False)
    """The response on the grid."""

    def response(self, w: np.ndarray) -> np.ndarray:
        """``G1`` at the frequencies ``w``."""
        if w is self.grid.w and self.cached is not None:
            return self.cached
        g = self.loop.response(w)
        g = g / (1.0 + self.k1 * g)
        if w is self.grid.w:
            self.cached = g
        return g

    def z(self, w: np.ndarray) -> np.ndarray:
        """``e^(jwT)``."""
        return np.exp(1j * w * float(self.loop.dt or 0.0))


class Search(NamedTuple):
    """The best multiplier of a criterion."""

    best: Best
    q: float | None = None
    slope: float | None = None
    """Upper bound of the slope for which it holds."""
    data: dict[str, Any] = {}  # noqa: RUF012
    """What the drawing needs."""


def ask(
    criterion: Name,
    loop: LinearLoop,
    k1: float | None = None,
    k2: float | None = None,
    nonlinearity: Lure | None = None,
    *,
    q: float | None = None,
    slope: float | None = None,
    taps: int | None = None,
    grid: Any = None,
) -> Certificate:
    """The certificate of a sector by one criterion, or of the largest sector from ``k1`` on where ``k2`` is not given.

    Args:
        criterion: a name of :data:`CRITERIA`.
        loop: cut at the error; ``popov`` replaces a sampled one by its continuous model.
        k1: lower bound of the sector; that of ``nonlinearity`` where not given, else 0.
        k2: upper bound; that of ``nonlinearity`` where not given, else as large as can be proved.
        nonlinearity: checked against the sector and for the properties that the criterion needs.
        q: multiplier of Popov (s), Tsypkin and Jury-Lee; the best one where not given.
        slope: upper bound ``s2`` of the slope, for Jury-Lee and Zames-Falb; that of ``nonlinearity`` where not given,
            else ``k2`` (Jury-Lee) and none (Zames-Falb).
        taps: delays of Zames-Falb's multiplier to either side, in periods: 10 where not given.
        grid: frequencies in rad/s; the loop's own where not given.

    Raises:
        ValueRefused: no such criterion, one that is not for this loop or has no such option, bounds out of order.
    """
    if criterion not in CRITERIA:
        raise ValueRefused(f"criterion {criterion!r}: there are {', '.join(CRITERIA)}")
    row = CRITERIA[criterion]
    for name, value in (("q", q), ("slope", slope), ("taps", taps)):
        if value is not None and name not in row.options:
            raise ValueRefused(f"{criterion}: it has no {name}")
    if row.loops == "sampled" and not loop.sampled:
        raise ValueRefused(
            f"{criterion}: the loop {loop.name!r} is continuous; ask popov, which is for continuous loops"
        )
    if taps is not None and taps < 1:
        raise ValueRefused(f"{criterion}: taps = {taps!r}; allowed from 1")
    notes: list[str] = []
    if row.loops == "continuous" and loop.sampled:
        notes.append(
            f"{row.title} is a criterion for continuous loops: what is proved is proved for the continuous model of "
            f"{loop.name!r}, not for the loop as it is sampled; for that one ask circle, tsypkin or jury-lee."
        )
        loop = continuous_model(loop)
    if k1 is None:
        k1 = 0.0 if nonlinearity is None else float(nonlinearity.sector[0])
    if k2 is None and nonlinearity is not None and nonlinearity.nonlinear:
        k2 = float(nonlinearity.sector[1])
    if not math.isfinite(k1) or (k2 is not None and not (math.isfinite(k2) and k2 > k1)):
        raise ValueRefused(
            f"{criterion}: sector [{k1!r}, {k2!r}]: allowed are finite numbers, the first below the second"
        )
    wrong: list[str] = []
    own = own_grid(loop)
    if grid is not None:
        own, wrong = given_grid(loop, grid)
    nyquist = loop.gain_limit(k1)
    critical = not loop.stable(k1) and nyquist > k1
    problem = Problem(row, loop, float(k1), k2, own, nyquist, critical, q, slope, taps or TAPS)
    problem.warnings = [*notes, *loop.notes, *wrong]
    if k1 < nyquist < 1.0 and loop.stable(1.0):
        problem.warnings.append(f"{CONDITIONAL}: begin the sector at the controller's least gain, not at {k1:g}.")
    refusal = _loop_refusal(problem) or (wrong[0] if wrong else "")
    if nonlinearity is not None:
        problem.warnings += _remarks(problem, nonlinearity)
        if "slope" in row.options and nonlinearity.slope_sector is not None and slope is None:
            problem.slope = float(nonlinearity.slope_sector[1])
        refusal = refusal or _law_refusal(problem, nonlinearity)
    refusal = refusal or _critical_refusal(problem)
    if refusal:
        return Certificate(
            row.title, "refused", refusal, of_loop(loop), _sector(problem), grid=own.as_dict(),
            warnings=problem.warnings,
        )  # fmt: skip
    return _certificate(problem, row.search(problem))


def _sector(problem: Problem) -> tuple[float, float]:
    return problem.k1, math.inf if problem.k2 is None else problem.k2


def _loop_refusal(problem: Problem) -> str:
    loop, k1, k2 = problem.loop, problem.k1, problem.k2
    if problem.nyquist <= k1:
        gain = k1 if k1 != 0.0 else 1.0
        if loop.stable(gain):
            return f"{CONDITIONAL}: no sector from {k1:g} can be proved; begin it at the controller's least gain."
        return (
            f"The loop is unstable with a gain of {gain:g} ({worst_pole(loop, gain)}): it has to be stabilised before "
            "any sector that contains that gain can be asked about."
        )
    if k2 is not None and k2 >= problem.nyquist:
        return (
            f"The sector {interval(k1, k2)} reaches beyond the Nyquist limit: with a constant gain of "
            f"{problem.nyquist:.4g} the loop already oscillates, so no criterion can prove more."
        )
    return ""


def _law_refusal(problem: Problem, law: Lure) -> str:
    """Why the criterion does not hold for the nonlinearity; empty where it does."""
    row, k1, k2 = problem.criterion, problem.k1, problem.k2
    low, high = law.sector
    slopes = law.slope_sector
    lacks = row.lacks(law, k1)
    if lacks == "static":
        return (
            f"The gain of {law.block.name} multiplies the controller's output: it is no static map of the error, which "
            f"{row.title} needs; the circle criterion holds for it."
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
    if slopes is not None and lacks == "monotone":
        return (
            f"The slope of the nonlinearity falls to {slopes[0]:.4g}, below the sector's lower bound of {k1:g}: "
            f"{row.title} needs a slope nowhere below it."
        )
    if lacks == "odd":
        return f"The nonlinearity is not odd, which {row.title} needs."
    if slopes is not None and problem.slope is not None and slopes[1] > problem.slope + 1e-9:
        return (
            f"The slope of the nonlinearity reaches {slopes[1]:.4g}, above the bound of {problem.slope:g} that was "
            "asked for."
        )
    return ""


def _critical_refusal(problem: Problem) -> str:
    if not problem.critical:
        return ""
    if problem.criterion.title == "Zames-Falb":
        return "With an integrator in the loop the sector has to start above 0 for the multiplier of Zames and Falb."
    if problem.q is not None and problem.q < 0.0:
        return f"q = {problem.q:g}: with an integrator in the loop and a sector from 0 it must not be negative."
    return ""


def _remarks(problem: Problem, law: Lure) -> list[str]:
    low, high = law.sector
    remarks = list(law.notes)
    if problem.k1 < low - 1e-9:
        remarks.append(
            f"The nonlinearity's gain is never below {low:.4g}; the sector from {problem.k1:g} asks for more than "
            "needed."
        )
    done = abs(float(law.gain(SMALL_ERROR_MM)) - float(law.gain(0.0)))
    if high > low and done < NOTHING * (high - low):
        remarks.append(
            f"The nonlinearity counts its error in {law.error_unit}: at an error of "
            f"{1e3 * SMALL_ERROR_MM:g} um its gain has changed by {done:.2g} of {high - low:.3g}. If the axis errs by "
            "micrometres the controller is a linear one; is the unit right?"
        )
    slopes = law.slope_sector
    if slopes is not None and slopes[1] > problem.nyquist:
        remarks.append(
            f"The slope of the nonlinearity reaches {slopes[1]:.4g}, above the Nyquist limit of "
            f"{number(problem.nyquist)}: a load or a following error that holds the error there makes the loop "
            "oscillate, whatever is proved of the loop left alone. Ask driven()."
        )
    return remarks


def _certificate(problem: Problem, search: Search) -> Certificate:
    row, loop, k1, k2 = problem.criterion, problem.loop, problem.k1, problem.k2
    m = search.best.m
    limit = min(limit_of(k1, m), problem.nyquist)
    upper = limit if k2 is None else k2
    proved = k2 is None or k2 < limit
    warnings = list(problem.warnings)
    if not search.best.settled:
        warnings.append("The tightest frequency was not bracketed: the limit may be a little too large.")
    if k2 is not None and proved and limit < 1.02 * k2:
        warnings.append(f"The limit of {number(limit)} leaves {100 * (limit / k2 - 1):.1f} % of reserve in the gain.")
    if proved:
        lower = f"{k1:g} {'<' if problem.critical else '<='}"
        bound = "" if math.isinf(upper) else f" {'<=' if k2 is not None else '<'} {upper:.4g}"
        slope = math.inf if search.slope is None else search.slope
        laws = row.proves.format(k1=f"{k1:g}", slope=number(slope), slopes=interval(k1, slope))
        statement = (
            f"The error dies out from every initial state for every nonlinearity with {lower} phi(e)/e{bound}{laws}, "
            "while command and load stand at zero."
        )
    else:
        statement = (
            f"Not proved: the criterion reaches {number(limit)}, the sector asked for {k2:.4g}; the loop may be "
            f"stable all the same, the Nyquist limit being {number(problem.nyquist)}."
        )
    at = search.best.at
    grid = Grid(search.best.w, problem.grid.chosen, search.best.added).as_dict()
    grid |= {"points": len(search.best.w) - search.best.added, "tightest": at}
    return Certificate(
        row.title, "grid-checked" if proved else "refused", statement, of_loop(loop), _sector(problem), limit,
        None if k2 is None else limit / k2, search.q, grid, warnings,
        {"nyquist_limit": problem.nyquist, "tightest_rad_s": at, "m": m, "k1": k1, "loop": loop, **search.data},
        row.drawing,
    )  # fmt: skip


# ---- the conditions: intercepts r and slopes s of h = r + |q| s, from the response


def tsypkin_lines(g: np.ndarray, z: np.ndarray, sign: float, slope: float = math.inf) -> tuple[np.ndarray, np.ndarray]:
    """Tsypkin's; ``slope`` is ``s2 - k1``, where the slope has an upper bound (one tap of Zames and Falb)."""
    return -g.real, -((1.0 - (1.0 / z if sign > 0.0 else z)) * (g + 1.0 / slope)).real


def jury_lee_lines(g: np.ndarray, z: np.ndarray, sign: float, slope: float) -> tuple[np.ndarray, np.ndarray]:
    """Jury and Lee's; ``slope`` is ``s2 - k1``."""
    turned = z - 1.0 if sign > 0.0 else 1.0 / z - 1.0
    return -g.real, -(turned * g).real + 0.5 * slope * np.abs((z - 1.0) * g) ** 2


def popov_lines(g: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Popov's."""
    return -g.real, w * g.imag


def _circle(problem: Problem) -> Search:
    def lines(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return -problem.response(w).real, np.zeros(len(w))

    d = float(problem.loop.d[0, 0])
    ends = () if problem.loop.sampled else ((-d / (1.0 + problem.k1 * d), 0.0),)
    return Search(best(lines, problem.grid.w, 0.0, 0.0, 0.0, 1.0, ends))


def _popov(problem: Problem) -> Search:
    loop, d = problem.loop, float(problem.loop.d[0, 0])
    lead = float((loop.c @ loop.b)[0, 0])
    ends = [(-d / (1.0 + problem.k1 * d), -lead)]
    if loop.dead_time:
        ends.append((0.0, lead))
    poles = np.abs(loop.closed_poles(problem.k1 if problem.k1 else 1.0))
    lowest = 0.0 if problem.critical else -math.inf
    chosen = best(
        lambda w: popov_lines(problem.response(w), w), problem.grid.w, problem.q, lowest, math.inf,
        1.0 / float(poles.max()), tuple(ends),
    )  # fmt: skip
    return Search(chosen, chosen.q, None, {"q_s": chosen.q, "response": problem.response})


def _tsypkin(problem: Problem) -> Search:
    return _sided(problem, lambda w, sign: tsypkin_lines(problem.response(w), problem.z(w), sign))


def _jury_lee(problem: Problem) -> Search:
    slope = problem.k2 if problem.slope is None else problem.slope
    if slope is not None and not slope >= problem.k1:
        raise ValueRefused(f"jury-lee: slope = {slope!r}: allowed from {problem.k1:g}, the sector's lower bound")

    def searched(bound: float, rounds: int = ROUNDS) -> Search:
        return _sided(
            problem, lambda w, sign: jury_lee_lines(problem.response(w), problem.z(w), sign, bound - problem.k1), rounds
        )

    if slope is None:  # the largest bound of sector and slope alike, by halving, on the grid as it is
        slope, high = problem.k1, problem.nyquist if math.isfinite(problem.nyquist) else problem.k1 + 1e6
        for _ in range(HALVINGS):
            middle = 0.5 * (slope + high)
            reaches = limit_of(problem.k1, searched(middle, 1).best.m) > middle
            slope, high = (middle, high) if reaches else (slope, middle)
            if high - slope <= 1e-7 * high:
                break
    chosen = searched(slope)
    return chosen._replace(slope=slope, data={**chosen.data, "slope": slope})


def _sided(problem: Problem, lines: Callable[[np.ndarray, float], Any], rounds: int = ROUNDS) -> Search:
    """The better of the multipliers of both signs, each searched by its size."""
    q = problem.q
    signs = (1.0, -1.0) if q is None else (1.0 if q >= 0.0 else -1.0,)
    tried: list[tuple[Best, float]] = []
    for sign in (1.0,) if problem.critical else signs:
        size = None if q is None else abs(q)
        one = best(lambda w, s=sign: lines(w, s), problem.grid.w, size, 0.0, math.inf, 1.0, (), rounds)  # type: ignore[misc]
        tried.append((one, sign))
    chosen, sign = max(tried, key=lambda t: limit_of(problem.k1, t[0].m))
    signed = sign * chosen.q
    side = 1.0 if signed >= 0.0 else -1.0
    return Search(chosen, signed, None, {"lines": lambda w: lines(w, side), "size": abs(signed)})


HALVINGS = 40
TAPS = 10
"""Delays of the multiplier to either side, in periods: twice as many gain 0.2 % on the loop L* of the XY table."""
FIRST = 200
WORST = 20
PROGRAMS = 30
EDGE = 1e-6
"""Below the Nyquist limit by this, relative: at it no condition holds."""
NEAR = 1e-4
"""How exactly a limit beyond the slope is searched, relative."""
LARGEST = 1e4
"""Bound of the multiplier's coefficients: beyond it their differences are rounding."""
SMALL = 1e-6
"""What a coefficient costs, against ``1 / (k2 - k1)``: of multipliers of the same reach the smallest."""


def _zames_falb(problem: Problem) -> Search:
    slope = math.inf if problem.slope is None else problem.slope
    if not slope > problem.k1:
        raise ValueRefused(f"zames-falb: slope = {slope!r}: allowed above {problem.k1:g}, the sector's lower bound")
    steepest = _steepest(problem, slope)
    weights = _linear_program(problem, steepest)

    def lines(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        r, columns = _coefficients(problem, w, steepest)
        return r + columns @ weights, np.zeros(len(w))

    chosen = best(lines, problem.grid.w, 0.0, 0.0, 0.0, 1.0)
    if steepest > slope and limit_of(problem.k1, chosen.m) > steepest:
        chosen = replace(chosen, m=1.0 / (steepest - problem.k1))
    data = {"lines": lines, "size": 0.0, "taps": problem.taps, "weights": weights, "slope": steepest}
    return Search(chosen, None, steepest if problem.k2 is None else slope, data)


def _steepest(problem: Problem, slope: float) -> float:
    """The slope to prove the limit with: ``slope``, or the largest proved for sector and slope alike, if more."""
    if slope >= problem.nyquist or not _reaches(problem, slope):
        return slope
    low, high = slope, problem.nyquist
    if math.isinf(high):
        return slope
    if _reaches(problem, high * (1.0 - EDGE)):
        return high * (1.0 - EDGE)
    while high - low > NEAR * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _reaches(problem, middle) else (low, middle)
    return low


def _reaches(problem: Problem, slope: float) -> bool:
    """Whether the sector is proved up to the slope, on the grid as it is."""
    r, columns = _coefficients(problem, problem.grid.w, slope)
    m = float((r + columns @ _linear_program(problem, slope)).max())
    return limit_of(problem.k1, m) >= slope * (1.0 - 1e-9)


def _coefficients(problem: Problem, w: np.ndarray, slope: float) -> tuple[np.ndarray, np.ndarray]:
    """``-Re G1``, and what each of the multiplier's coefficients adds to it."""
    g, taps = problem.response(w), problem.taps
    delays = np.concatenate([np.arange(-taps, 0), np.arange(1, taps + 1)])
    turned = np.exp(-1j * np.outer(w * float(problem.loop.dt or 0.0), delays))
    bent = (g + 1.0 / (slope - problem.k1))[:, None]
    return -g.real, -np.hstack([((1.0 - turned) * bent).real, ((1.0 + turned) * bent).real])


def _linear_program(problem: Problem, slope: float) -> np.ndarray:
    """The coefficients of most reach."""
    from scipy.optimize import linprog

    w = problem.grid.w
    r, columns = _coefficients(problem, w, slope)
    count = columns.shape[1]
    used = np.unique(np.linspace(0, len(w) - 1, FIRST).astype(int))
    weights = np.zeros(count)
    # no sector reaches beyond the Nyquist limit, nor beyond the largest slope
    smallest = 1.0 / (min(problem.nyquist, slope) - problem.k1)
    bounds = [(0.0, LARGEST)] * count + [(smallest, None)]
    for _ in range(PROGRAMS):
        rows = np.hstack([columns[used], -np.ones((len(used), 1))])
        cost = np.append(np.full(count, SMALL), 1.0)
        solved = linprog(cost, A_ub=rows, b_ub=-r[used], bounds=bounds, method="highs")
        if solved.x is None:
            break
        weights, m = solved.x[:count], float(solved.x[count])
        h = r + columns @ weights
        if h.max() <= m + 1e-9 * (1.0 + abs(m)):
            break
        used = np.union1d(used, np.argsort(-h)[:WORST])
    return np.asarray(weights)


CRITERIA: dict[Name, Criterion] = {
    "circle": Criterion("circle", ", also one that varies with time", "both", (), (), _circle, "circle"),
    "tsypkin": Criterion(
        "Tsypkin", ", time-invariant, with a slope nowhere below {k1}", "sampled", ("static", "monotone"), ("q",),
        _tsypkin,
    ),
    "jury-lee": Criterion(
        "Jury-Lee", ", time-invariant, with a slope of at most {slope}", "sampled", ("static",), ("q", "slope"),
        _jury_lee,
    ),
    "zames-falb": Criterion(
        "Zames-Falb", ", time-invariant and odd, with a slope in {slopes}", "sampled",
        ("static", "monotone", "odd"), ("slope", "taps"), _zames_falb,
    ),
    "popov": Criterion(
        "Popov", " that does not change with time", "continuous", ("static",), ("q",), _popov, "popov"
    ),
}  # fmt: skip
"""By name, in the order in which :func:`leadscrew.analysis.stability.certification.certify` asks them."""
