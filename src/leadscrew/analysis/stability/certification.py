"""A whole loop certified: taken apart, every criterion that applies asked, one verdict.

1. The controller is taken apart (:mod:`leadscrew.analysis.stability.lure`); the linear loop is taken from the steps
   that run and are exported (:mod:`leadscrew.analysis.stability.sampled`), with its delays as states.
2. Margins of the linear loop.
3. Level 1, *autonomous*: left alone the loop returns to rest. Circle, Tsypkin, Jury-Lee, Zames-Falb on the sampled
   loop, Popov on its continuous model (which proves nothing of the sampled one and never counts), and the first of
   circle, Tsypkin or Jury-Lee, and Zames-Falb that holds as a matrix inequality.
4. Level 2, *driven*: under load and on the move too. The circle criterion on the sector of the slope.
5. What chatters, by the describing function, where the slope exceeds the Nyquist limit.

:func:`leadscrew.analysis.stability.certifying.certify` does it. The verdict is about the level that was asked for. A
linear controller has one level, the second: its loop is stable or not. A simulation that diverges overrules any proof:
then something that runs is not in the proof.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate, interval, loop_line, number
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.lure import Lure

if TYPE_CHECKING:
    from leadscrew.analysis.stability.cycles import CyclePrediction
    from leadscrew.analysis.stability.margins import Margins

Level = Literal["autonomous", "driven"]
LEVELS: tuple[Level, ...] = ("autonomous", "driven")

SCHEMA_VERSION = 1
GRADES = ("certificate", "grid-checked", "refused")


@dataclass(frozen=True)
class Certification:
    """Everything that was found of a loop; ``report()`` is the text, ``as_dict()`` the JSON."""

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
            said = f"its slope reaches {slopes[1]:.4g}, above the Nyquist limit of {number(limit)}"
            return f"{said}: under load it chatters."
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
        found = [*self.warnings]
        for c in (self.margins, *self.autonomous, self.model, self.driven):
            found += [] if c is None else [w for w in c.warnings if not w.endswith("Ask driven().")]
        if self.run is not None:
            found = [w for w in found if not w.startswith("The nonlinearity counts its error in")]
        return tuple(dict.fromkeys(found))


def whole(certificate: Certificate) -> dict[str, Any]:
    """A certificate for JSON with the matrix of its Lyapunov function ``x' P x``, by which anybody can check it."""
    p = certificate.data.get("p")
    return {**certificate.as_dict(), **({} if p is None else {"p": np.asarray(p, dtype=float).tolist()})}


def line(certificate: Certificate) -> str:
    """A criterion in a line: grade, limit, what was asked."""
    c = certificate
    said = f"  {c.criterion:26s} {c.grade:12s}"
    if c.limit is not None and c.sector is not None:
        said += f" up to {number(c.limit)} of {number(c.sector[1])} asked"
    if c.multiplier is not None and c.limit is not None:
        said += f", q = {c.multiplier:.4g}"
    return said.rstrip()


def run_line(run: Mapping[str, Any], taken: Lure) -> str:
    """The simulation in words."""
    if run["diverged"] is not None:
        return f"simulated {run['seconds']:g} s: {run['diverged']}"
    said = f"simulated {run['seconds']:g} s: error up to {1e3 * run['largest_error_mm']:.4g} um"
    if taken.nonlinear:
        said += f", where the gain is {run['gain']:.6g}"
    return f"{said}; output up to {run['largest_output']:.3g} {run['unit']}".rstrip()
