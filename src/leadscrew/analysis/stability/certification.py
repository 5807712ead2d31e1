"""A whole loop certified: taken apart, every criterion that applies asked, one verdict.

1. The controller is taken apart (:mod:`leadscrew.analysis.stability.lure`); the linear loop is taken from the steps
   that run and are exported (:mod:`leadscrew.analysis.stability.loop`), with its delays as states.
2. Margins of the linear loop.
3. Level 1, *autonomous*: left alone the loop returns to rest. Every sampled criterion of
   :data:`~leadscrew.analysis.stability.criteria.CRITERIA` whose needs the map meets, and the first of circle, Tsypkin
   or Jury-Lee, and Zames-Falb that holds as a matrix inequality. Popov on the continuous model, where it is wanted: it
   proves nothing of the sampled loop and never counts.
4. Level 2, *driven*: under load and on the move too. The circle criterion on the sector of the slope.
5. What chatters, by the describing function, where the slope exceeds the Nyquist limit.

The verdict is about the level that was asked for. A linear controller has one level, the second: its loop is stable or
not. A simulation that diverges overrules any proof: then something that runs is not in the proof.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate, interval, loop_line, number, of_loop
from leadscrew.analysis.stability.criteria import CRITERIA, ask
from leadscrew.analysis.stability.harmonic_balance import CyclePrediction, limit_cycles
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.lmi import driven, prove
from leadscrew.analysis.stability.loop import sampled_loop
from leadscrew.analysis.stability.lure import Lure, lure
from leadscrew.analysis.stability.margins import Margins, margins
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop


Level = Literal["autonomous", "driven"]
LEVELS: tuple[Level, ...] = ("autonomous", "driven")

SCHEMA_VERSION = 1
GRADES = ("certificate", "grid-checked", "refused")


@dataclass(frozen=True)
class Certification:
    """Margins, certificates, cycle and run of one loop; ``report()`` is the text, ``as_dict()`` the JSON."""

    loop: Mapping[str, Any]
    taken: Lure = field(repr=False)
    linear: LinearLoop = field(repr=False)
    level: Level
    factor: float
    """How far the limit has to exceed the bound: 1 for a proof, more for a reserve."""
    proof: bool
    """Whether only a matrix inequality, verified in exact arithmetic, counts."""
    margins: Margins
    stable: bool
    """The linear loop."""
    autonomous: tuple[Certificate, ...]
    model: Certificate | None
    """Popov, on the continuous model."""
    driven: Certificate | None
    cycle: CyclePrediction | None
    """The worst limit cycle under a load, where one is predicted."""
    warnings: tuple[str, ...]
    run: Mapping[str, Any] | None = None
    """What a simulation of the loop showed: largest error and output, gain and slope there."""

    def counts(self, certificate: Certificate | None) -> bool:
        """Whether a certificate proves what was asked, by the grade that was asked."""
        if certificate is None or not certificate.proved:
            return False
        if self.proof and certificate.grade != "certificate":
            return False
        return self.factor <= 1.0 or (
            certificate.margin is not None and certificate.margin >= self.factor * (1.0 - 1e-9)
        )

    @property
    def diverged(self) -> bool:
        """Whether the loop was simulated and diverged."""
        return self.run is not None and self.run["diverged"] is not None

    @property
    def _under_command(self) -> bool:
        """Whether the verdict rests on level 2: it was asked, or the controller is linear and both levels are one."""
        return self.level == "driven" or not self.taken.nonlinear

    @property
    def passed(self) -> bool:
        """Whether the loop is certified as asked."""
        if not self.stable or self.diverged:
            return False
        if self._under_command:
            return self.counts(self.driven)
        return any(self.counts(c) for c in self.autonomous)

    @property
    def best(self) -> Certificate | None:
        """The certificate that the verdict rests on: the level's strongest; where none counts, of most reach."""
        if self._under_command:
            return self.driven
        counted = [c for c in self.autonomous if self.counts(c)]
        if counted:
            return min(counted, key=lambda c: (GRADES.index(c.grade), -(c.limit or 0.0)))
        verified = [c for c in self.autonomous if c.grade == "certificate"]
        among = verified if self.proof and verified else self.autonomous
        return max(among, key=lambda c: c.limit or 0.0, default=None)

    @cached_property
    def nyquist(self) -> float:
        """Largest constant gain of the map with which the loop is stable, from the lower bound of the sector on."""
        return self.linear.gain_limit(self.taken.sector[0])

    @property
    def grade(self) -> str:
        """Of the verdict."""
        best = self.best
        return "refused" if not self.passed or best is None else best.grade

    @property
    def verdict(self) -> str:
        """One line."""
        name = self.taken.block.name
        if not self.stable:
            return f"NOT CERTIFIED: the linear loop of {name} is unstable."
        if self.run is not None and self.diverged:
            return (
                f"NOT CERTIFIED: simulated for {self.run['seconds']:g} s, the scenario diverged: "
                f"{str(self.run['diverged']).rstrip('.')}. Something that runs in it is not in the proof of {name} (a "
                "limit of the drive, say), so what is proved does not count."
            )
        kind = {"certificate": "a verified matrix inequality", "grid-checked": "a check on a grid of frequencies"}
        if not self.taken.nonlinear and self.passed:
            return f"CERTIFIED: {name} is linear and its sampled loop is stable ({kind[self.grade]})."
        what = "under every command and load" if self._under_command else "at rest, without command and load"
        if self.passed:
            return f"CERTIFIED: {name} is stable {what}, by {kind[self.grade]}."
        if self.factor > 1.0:
            what += f", with a reserve of {self.factor:g} times"
        rest = [c.grade for c in self.autonomous if self.counts(c)]
        if self.level == "driven" and rest:
            grade = "proved" if "certificate" in rest else "checked on a grid"
            return f"NOT CERTIFIED: {name} is stable at rest ({grade}), but not proved {what}: {self._why()}"
        return f"NOT CERTIFIED: {name} is not proved stable {what}: {self._why()}"

    def _why(self) -> str:
        slopes, limit = self.taken.slope_sector, self.nyquist
        if self.level == "driven" and self.driven is None:
            return "its gain stands behind the linear part, for which the slope says nothing."
        if self.level == "driven" and slopes is not None and slopes[1] >= limit:
            steep = f"its slope reaches {slopes[1]:.4g}, above the Nyquist limit of {number(limit)}"
            return f"{steep}: under load it chatters."
        best = self.best
        if best is None:
            return "no criterion applies."
        if best.limit is not None and best.proved:
            # the slope where level 2 is asked; a linear controller has the same bound at both
            asked = (slopes or self.taken.sector)[1] if self._under_command else self.taken.sector[1]
            grade = f" ({best.grade})" if self.proof and best.grade != "certificate" else ""
            return (
                f"the limit of {number(best.limit)} is {best.limit / asked:.4g} times its bound of {asked:.4g}, by "
                f"{best.criterion}{grade}."
            )
        return best.statement

    def as_dict(self) -> dict[str, Any]:
        """For JSON; everything but the drawings."""
        t = self.taken
        return {
            "schema_version": SCHEMA_VERSION,
            "certified": self.passed,
            "grade": self.grade,
            "verdict": self.verdict,
            "asked": {"level": self.level, "factor": self.factor, "proof": self.proof},
            "loop": {**self.loop, **{k: getattr(self.linear, k).tolist() for k in "abcd"}},
            "map": {
                "controller": t.block.name, "nonlinear": t.nonlinear, "dependent": t.dependent,
                "sector": list(t.sector), "slope_sector": None if t.slope_sector is None else list(t.slope_sector),
                "error_unit": t.error_unit, "scale_mm": t.scale_mm if math.isfinite(t.scale_mm) else None,
            },
            "stable": self.stable,
            "margins": self.margins.as_dict(),
            "nyquist_limit": self.nyquist if math.isfinite(self.nyquist) else "inf",
            "autonomous": [whole(c) for c in self.autonomous],
            "model": None if self.model is None else self.model.as_dict(),
            "driven": None if self.driven is None else whole(self.driven),
            "limit_cycle": None if self.cycle is None else {
                "load_mm": self.cycle.load, "statement": self.cycle.statement,
                "cycles": [c.as_dict() for c in self.cycle.cycles],
            },
            "run": None if self.run is None else dict(self.run),
            "warnings": list(self.all_warnings),
        }  # fmt: skip

    def report(self) -> str:
        """All of it as text, the verdict last."""
        t, parts = self.taken, [f"loop        {loop_line(self.loop)}"]
        if t.nonlinear:
            place = "behind" if t.dependent else "beside" if t.map.shared is not None else "in front of"
            slopes = "" if t.slope_sector is None else f", slope {interval(*t.slope_sector)}"
            parts.append(
                f"controller  {t.block.name}: a gain K(e) in {interval(*t.sector)}{slopes}, {place} a linear "
                f"controller; it counts the error in {t.error_unit}"
            )
        else:
            parts.append(f"controller  {t.block.name}: linear")
        parts.append(f"margins     {self.margins.statement}")
        if t.nonlinear:
            parts += ["", "LEVEL 1, AUTONOMOUS: command and load at zero", *map(line, self.autonomous)]
            first = min(self.autonomous, key=lambda c: (GRADES.index(c.grade), -(c.limit or 0.0)))
            parts.append(f"  {first.statement}")
            if self.model is not None:
                parts.append(f"{line(self.model)}; on the {self.model.loop['name'].split(' of ')[0]}, does not count")
            parts += ["", "LEVEL 2, DRIVEN: any command, any load"]
            if self.driven is None:
                parts.append("  no criterion applies")
        if self.driven is not None:
            parts += ["" if not t.nonlinear else line(self.driven), f"  {self.driven.statement}"]
        if self.cycle is not None:
            parts.append(
                f"  describing function, a prediction: under a load that asks for an error of "
                f"{1e3 * self.cycle.rest_error:.3g} um: {self.cycle.statement}"
            )
        if self.run is not None:
            parts += ["", run_line(self.run, t)]
        parts += [f"warning: {w}" for w in self.all_warnings]
        return "\n".join([*(p for p in parts if p is not None), "", self.verdict])

    @property
    def all_warnings(self) -> tuple[str, ...]:
        """The warnings of every part, each once; less what the second level says itself."""
        warnings = [*self.warnings]
        for c in (self.margins, *self.autonomous, self.model, self.driven):
            warnings += [] if c is None else [w for w in c.warnings if not w.endswith("Ask driven().")]
        if self.run is not None:
            warnings = [w for w in warnings if not w.startswith("The nonlinearity counts its error in")]
        return tuple(dict.fromkeys(warnings))


def whole(certificate: Certificate) -> dict[str, Any]:
    """A certificate for JSON with the matrix of its Lyapunov function ``x' P x``, by which anybody can check it."""
    p = certificate.data.get("p")
    return {**certificate.as_dict(), **({} if p is None else {"p": np.asarray(p, dtype=float).tolist()})}


def line(certificate: Certificate) -> str:
    """A criterion in a line: grade, limit, what was asked."""
    c = certificate
    text = f"  {c.criterion:26s} {c.grade:12s}"
    if c.limit is not None and c.sector is not None:
        text += f" up to {number(c.limit)} of {number(c.sector[1])} asked"
    if c.multiplier is not None and c.limit is not None:
        text += f", q = {c.multiplier:.4g}"
    return text.rstrip()


def run_line(run: Mapping[str, Any], taken: Lure) -> str:
    """The simulation in words."""
    if run["diverged"] is not None:
        return f"simulated {run['seconds']:g} s: {run['diverged']}"
    text = f"simulated {run['seconds']:g} s: error up to {1e3 * run['largest_error_mm']:.4g} um"
    if taken.nonlinear:
        text += f", where the gain is {run['gain']:.6g}"
    return f"{text}; output up to {run['largest_output']:.3g} {run['unit']}".rstrip()


MOST_STATES = 100
"""More take minutes: an exact proof costs the fourth power of their number."""
LOWEST_RAD_S = 1e-4
"""Where a grid of a given number of points begins."""
WIDEST_TURN = math.pi / 4
"""Largest turn of the loop's phase between two frequencies of a grid, where its gain still matters."""
LOADS = 9
"""Loads at which the describing function is asked, between those that hold the error where the slope is too large."""
BEYOND = 2.5
"""Up to this many times the error at which the map reaches its bound."""
RAN_AWAY = 100.0
"""An error this many times the largest command is one of a loop that diverges, by a limit of its drive more slowly."""
IDLE = 0.01
"""Part of the way from its smallest to its largest gain that a nonlinearity must go in a run, or it does nothing."""


def certify(
    loop: Loop,
    *,
    level: Level = "driven",
    factor: float = 1.0,
    proof: bool = False,
    points: int | None = None,
    seconds: float | None = None,
    name: str = "",
    model: bool = False,
) -> Certification:
    """Everything that the criteria say of a sampled loop.

    Args:
        loop: a built loop with a sampled controller.
        level: what the verdict is about: ``autonomous`` or ``driven``.
        factor: how many times the proved limit must exceed the sector's or the slope's upper bound.
        proof: count matrix inequalities alone, not checks on a grid.
        points: frequencies of the grid for the criteria that are checked on one, evenly spaced in their logarithm from
            1e-4 rad/s to half the sampling rate; the loop's own grid unless given.
        seconds: simulate the loop this long, to see whether the nonlinearity does anything at its errors.
        name: what the loop is called in the sentences.
        model: also ask Popov, of the loop's continuous model: for comparison, it proves nothing of the sampled loop.

    Raises:
        ValueRefused: an option out of range, or a loop without a period or that cannot be taken apart; it says why.
    """
    if level not in LEVELS:
        raise ValueRefused(f"level = {level!r}: there are {', '.join(LEVELS)}")
    if not (math.isfinite(factor) and factor >= 1.0):
        raise ValueRefused(f"factor = {factor!r}: a reserve is a factor from 1 on")
    if points is not None and points < 3:
        raise ValueRefused(f"points = {points!r}: a grid has at least 3")
    block = loop.blocks["controller"]
    assert block is not None
    _check_size(loop)
    taken = lure(block, loop.period)
    whole = sampled_loop(with_controller(loop, taken.linear), name or loop.name)
    linear = whole if taken.map.shared is None else around(loop, taken, name or loop.name)
    grid = None if points is None else np.geomspace(LOWEST_RAD_S, linear.nyquist, points)
    stable = whole.stable(1.0)
    autonomous: tuple[Certificate, ...] = ()
    popov, under_command, cycle, gaps = None, None, None, None
    if taken.nonlinear:
        autonomous = _autonomous(linear, taken, grid)
        gaps = None if grid is None else _gaps(linear, grid)
        if gaps is not None:
            autonomous = tuple(
                replace(c, grade="refused", statement=gaps) if c.grade == "grid-checked" else c for c in autonomous
            )
        popov = _popov(linear, taken) if model else None
    if taken.slope_sector is not None:
        under_command = driven(linear, taken.slope_sector)
    if stable and taken.nonlinear and not taken.dependent and taken.map.shared is None:
        cycle = _worst_cycle(linear, taken)
    run = None if seconds is None else _run(loop, taken, seconds)
    warnings = [*([] if gaps is None else [gaps]), *taken.notes, *linear.notes, *_remarks(taken, run, block.full_scale)]
    return Certification(
        of_loop(linear), taken, linear, level, factor, proof, margins(whole), stable,
        autonomous, popov, under_command, cycle, tuple(dict.fromkeys(warnings)), run,
    )  # fmt: skip


def _check_size(loop: Loop) -> None:
    """Refuses a loop with more states than can be certified, before the work begins."""
    from leadscrew.kernel.layout import Layout

    block = loop.blocks["controller"]
    assert block is not None
    layout = Layout(loop.start_state(block))
    states = len(layout.scalars) + layout.array_size + loop.sent // loop.substeps
    if states > MOST_STATES:
        raise ValueRefused(
            f"{block.name} has {states} states with its delays, the memory of a repetitive controller for example; at "
            f"most {MOST_STATES} can be certified: put a resonator for each line in place of the memory"
        )


def with_controller(loop: Loop, block: Any) -> Loop:
    """The loop with another controller of the same signals."""
    other = loop.using({})
    other.blocks = {**loop.blocks, "controller": block}
    for kept in ("sheet", "module", "signals", "program"):
        other.__dict__.pop(kept, None)
    return other


def around(loop: Loop, taken: Lure, name: str) -> LinearLoop:
    """The loop from the map's output to the position, the linear path beside the map closed: ``e = -G phi(e)``.

    From the loops with ``phi(e) = s e`` at two values of ``s``: their states are the same, and what the error drives is
    linear in ``s``.

    Raises:
        ValueRefused: the states of the two differ, so the map is no linear path beside another.
    """
    assert taken.map.shared is not None
    low, high = (sampled_loop(with_controller(loop, taken.map.shared(s)), name) for s in (0.25, 0.75))
    if low.a.shape != high.a.shape or not (np.array_equal(low.a, high.a) and np.array_equal(low.c, high.c)):
        raise ValueRefused(f"{taken.block.name}: the states of its linear paths depend on how they share the error")
    through = 2.0 * (high.b - low.b)
    beside = low.b - 0.25 * through
    return LinearLoop(
        low.a - beside @ low.c, through, low.c, low.d, low.dt, name=name, notes=low.notes, from_blocks=True
    )


def _autonomous(linear: LinearLoop, taken: Lure, grid: Any) -> tuple[Certificate, ...]:
    k1, k2 = taken.sector
    checked = [
        ask(name, linear, nonlinearity=taken, grid=grid)
        for name, criterion in CRITERIA.items()
        if criterion.loops != "continuous" and criterion.lacks(taken, k1) is None
    ]
    first = prove("circle", linear, k1, k2)
    if taken.dependent or first.grade == "certificate":
        return (*checked, first)
    second = prove("best", linear, k1, k2, taken.slope_sector)
    slopes = taken.slope_sector
    if second.grade == "certificate" or not taken.odd or slopes is None or slopes[0] < k1:
        return (*checked, second)
    return (*checked, second, prove("zames-falb", linear, k1, k2, slopes))


def _gaps(linear: LinearLoop, grid: np.ndarray) -> str | None:
    """Where a grid is too coarse for the loop's phase, in a sentence; None where it will do."""
    g = linear.response(grid)
    turn = np.abs(np.angle(g[1:] / g[:-1]))
    turn[np.minimum(np.abs(g[1:]), np.abs(g[:-1])) < 0.01] = 0.0
    worst = int(np.argmax(turn))
    if turn[worst] <= WIDEST_TURN:
        return None
    return (
        f"The grid of {len(grid)} frequencies is too coarse: between {grid[worst]:.4g} and {grid[worst + 1]:.4g} rad/s "
        f"the loop's phase turns by {math.degrees(turn[worst]):.0f} deg, so that the tightest frequency can be missed. "
        f"At most {math.degrees(WIDEST_TURN):.0f} deg will do: more points, or none given for the loop's own grid."
    )


def _popov(linear: LinearLoop, taken: Lure) -> Certificate | None:
    """Popov on the continuous model of the loop; None where there is none."""
    if CRITERIA["popov"].lacks(taken, taken.sector[0]) is not None:
        return None
    try:
        return ask("popov", linear, nonlinearity=taken)
    except ValueRefused:
        return None


def _worst_cycle(linear: LinearLoop, taken: Lure) -> CyclePrediction | None:
    """The largest stable limit cycle over loads that hold the error where the slope exceeds the Nyquist limit."""
    limit = linear.gain_limit(taken.sector[0] if taken.sector[0] > 0.0 else 1.0)
    slopes = taken.slope_sector
    if slopes is None or not math.isfinite(limit) or slopes[1] < limit or not math.isfinite(taken.scale_mm):
        return None
    errors = taken.scale_mm * np.linspace(0.0, 3.0, 301)[1:]
    steep = errors[taken.slope(errors) >= limit]
    if not len(steep):
        return None
    least, most = 1e-3 * taken.scale_mm, 15.0 * taken.scale_mm
    table = taken.scale_mm * np.sinh(np.linspace(-12.0, 12.0, 20001)) * 1e-3
    values = taken.curve(table)
    best: CyclePrediction | None = None
    for at in np.linspace(steep[0], max(steep[-1], BEYOND * taken.scale_mm), LOADS):
        load = float(taken.curve(at))
        try:
            here = limit_cycles(linear, lambda e: np.interp(e, table, values), load, amplitudes=(least, most))
        except ValueRefused:  # a map that is flat there carries no such load
            continue
        size = max((c.amplitude for c in here.stable_cycles), default=0.0)
        if size > max((c.amplitude for c in best.stable_cycles), default=0.0) if best is not None else size > 0.0:
            best = here
    return best


def _run(loop: Loop, taken: Lure, seconds: float) -> dict[str, Any]:
    """Largest error and output of a simulation."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        done = loop.run(seconds, record=("true_error", "output", "command"))
    error = _first(done, "true_error")
    output = _first(done, "output")
    largest = float(np.abs(error).max(initial=0.0))
    block = loop.blocks["controller"]
    assert block is not None
    return {
        "seconds": seconds,
        "diverged": _diverged(done, error),
        "largest_error_mm": largest,
        "largest_output": float(np.abs(output).max(initial=0.0)),
        "unit": block.unit,
        "gain": float(taken.gain(largest)),
        "slope": float(taken.slope(largest)),
    }


def _diverged(run: Any, error: np.ndarray) -> str | None:
    """That the simulation diverged, in words: numbers beyond all bounds, or an error far beyond every command."""
    if run.diverged is not None:
        return str(run.diverged)
    most, command = float(np.abs(error).max(initial=0.0)), float(np.abs(_first(run, "command")).max(initial=0.0))
    if 0.0 < RAN_AWAY * command < most:
        return f"the error ran away to {most:.3g} mm, at a command of at most {command:.3g} mm"
    return None


def _first(run: Any, name: str) -> np.ndarray:
    return np.asarray(run.signals[next(k for k in run.signals if k == name or k.startswith(f"{name}."))])


def _remarks(taken: Lure, run: Mapping[str, Any] | None, full_scale: float) -> list[str]:
    """What the simulation says against the certificate's worth."""
    if run is None or run["diverged"] is not None:
        return []
    remarks = []
    low, high = taken.sector
    gone = abs(run["gain"] - float(taken.gain(0.0)))
    if taken.nonlinear and gone < IDLE * (high - low):
        remarks.append(
            f"K(e) never gets near its bound of {high:.4g} here: it reaches it at an error of {taken.scale_mm:.3g} mm, "
            f"and the error of this scenario stays within {1e3 * run['largest_error_mm']:.3g} um, where K has moved by "
            f"{gone:.2g}. The controller counts the error in {taken.error_unit}: whatever is proved is proved of a "
            "controller that does what its linear part does. Was um meant?"
        )
    if full_scale > 0.0 and run["largest_output"] >= 0.999 * full_scale:
        remarks.append(
            f"the output reaches its full scale of {full_scale:g} {run['unit']} in this scenario; a saturated drive is "
            "not in the proof"
        )
    return remarks
