"""A nonlinear law with a proof, against the best linear PID that is as robust and as quiet at rest.

The rule of the comparison. *As robust*: the peak of the sensitivity Ms of the linear PID bounds that of the nonlinear
loop linearised at **every** error, not only at rest. *As quiet*: at rest, with an encoder of 0.5 um and 0.1 um of
noise, the rms change of the output from sample to sample (:func:`rest_du_mv`) is no larger. Under these two the linear
PID with the smallest rows of Table II is sought over its gains and its filter (:func:`best_linear`); the nonlinear law
is :mod:`leadscrew.controllers.npid_split`, sought under the same two and the circle criterion on the robustness box.

The proof. With the quiet path closed, the rest is a Lur'e loop around ``large``, the part of the error that goes to the
difference of the paths; its slope lies in [0, 1] (:func:`around_large`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate
from leadscrew.analysis.stability.driven import driven
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.controllers.npid_split import NPIDSplitParams, NPIDSplitState, npid_split, paths
from leadscrew.controllers.pid import pid
from leadscrew.kernel.block import Block, controller
from leadscrew.kernel.sheet import Ge, Le
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.npid_xytable.calibration import PERIOD_S
from leadscrew.studies.npid_xytable.controllers import CONTROLLERS
from leadscrew.studies.npid_xytable.cutting import BOX, Trial, tried
from leadscrew.studies.npid_xytable.rejection import opened
from leadscrew.studies.npid_xytable.table2 import LINES_HZ, PID_UM, SPEEDS

MS = 1.6
"""Peak of the sensitivity that both may have."""
REST_DU_MV = 0.5
"""Change of the output at rest that both may have, mV."""
LINEAR = CONTROLLERS["ours.pid_quiet"]
"""What :func:`best_linear` finds."""
SPLIT = npid_split
"""The law that is compared: sought as :func:`searched` does, by an earlier form of it, and rounded by hand."""
SHARES = np.linspace(0.0, 1.0, 11)
"""Slopes of ``large`` at which the loop is linearised."""
OFFSETS = 8
"""Places within a count of the encoder at which the table stands still; their mean square counts."""
REST_S = 4.0


class SharedParams(NamedTuple):
    """The two paths, and which share of the error the firm one gets."""

    law: NPIDSplitParams = NPIDSplitParams()
    share: Annotated[float, Ge(0), Le(1)] = 0.5


@controller(SharedParams(), NPIDSplitState())
def shared(p, s, command, feedback, dt):
    """The two paths with fixed shares of the error: what npid_split is around one error."""
    error = command - feedback
    return paths(p.law, s, (1.0 - p.share) * error, p.share * error, dt)


def frozen(block: Block, share: float, changes: dict[str, float] | None = None) -> LinearLoop:
    """The loop of an npid_split where the slope of ``large`` is ``share``."""
    return opened(shared.using(**_law(block), share=float(share)), changes)


def around_large(block: Block, changes: dict[str, float] | None = None) -> LinearLoop:
    """The loop from ``large`` (and its ``-small``) to the position: quiet path closed, ``e = -G large(e)``.

    From the loops at shares of 1/4 and 3/4: their input columns are linear in the share.
    """
    low, high = frozen(block, 0.25, changes), frozen(block, 0.75, changes)
    if not (np.array_equal(low.a, high.a) and np.array_equal(low.c, high.c)):
        raise ValueError("the loop's states depend on the share")
    firm_less_quiet = 2.0 * (high.b - low.b)
    quiet = low.b - 0.25 * firm_less_quiet
    return LinearLoop(low.a - quiet @ low.c, firm_less_quiet, low.c, low.d, low.dt, name="L* with npid_split",
                      notes=low.notes, from_blocks=True)  # fmt: skip


class Reduction(NamedTuple):
    """By how many percent one law is below another."""

    rows: np.ndarray
    """Of the fifteen rows of Table II, each a mean over the draws."""
    row_off: np.ndarray
    """Half of the 95 % interval of each."""
    mean: float
    mean_off: float
    draws: int

    @property
    def least(self) -> int:
        """Which row is the smallest."""
        return int(np.argmin(self.rows))

    @property
    def words(self) -> str:
        """Mean and smallest row with their intervals."""
        return (
            f"mean {self.mean:.1f} ± {self.mean_off:.1f} %, smallest {self.rows.min():.1f} ± "
            f"{self.row_off[self.least]:.1f} % ({self.draws} draws a speed, 95 %)"
        )


def reduction(ours: Trial, theirs: Trial) -> Reduction:
    """Rows of the first against those of the second under the same draws; intervals by the jackknife over the draws."""
    from scipy.special import stdtrit

    amounts = [np.array([x.at(rpm) for rpm in SPEEDS]).swapaxes(0, 1).reshape(-1, 15) for x in (ours, theirs)]
    draws = len(amounts[0])

    def rows(kept: np.ndarray) -> np.ndarray:
        a, b = (x[kept].mean(axis=0) for x in amounts)
        return np.asarray(100.0 * (1.0 - a / b))

    def off(without: np.ndarray) -> np.ndarray:
        spread = np.sqrt((draws - 1) / draws * np.sum((without - without.mean(axis=0)) ** 2, axis=0))
        return np.asarray(stdtrit(draws - 1, 0.975) * spread)

    every = np.arange(draws)
    found = rows(every)
    without = np.array([rows(every[every != i]) for i in range(draws)])
    return Reduction(found, off(without), float(found.mean()), float(off(without.mean(axis=1))), draws)


def box_plants() -> list[dict[str, float]]:
    """The twelve plants of the robustness box, each as changes of parameters."""
    return [dict(zip(BOX, map(float, values), strict=True)) for values in zip(*BOX.values(), strict=True)]


def _law(block: Block) -> dict[str, Any]:
    p = block.params
    both = {"quiet": p.quiet, "firm": p.firm}
    found = {f"law.{path}.{name}": value for path, own in both.items() for name, value in own._asdict().items()}
    return {**found, "law.es_um": p.es_um}


def rest_du_mv(lab: Lab, blocks: list[Block]) -> np.ndarray:
    """Rms change of the output from sample to sample at rest, mV, of controllers of one kind.

    The table is asked to stand at :data:`OFFSETS` places within a count; the last three quarters of 4 s count.
    """
    from leadscrew.kernel.metrics import chatter
    from leadscrew.references.step import step

    loop = lab.loop(blocks[0], "quiet", reference=step(target=0.0),
                     metrics={"chatter": chatter(from_time=0.25 * REST_S)})  # fmt: skip
    places = 5e-4 * np.arange(OFFSETS) / OFFSETS
    varied: dict[str, Any] = {"reference.target": np.tile(places, len(blocks))}
    for key in (k for k in loop.parameters if k.startswith("controller.")):
        values = np.array([_value(block, key.removeprefix("controller.")) for block in blocks], dtype=float)
        if len(np.unique(values)) > 1:
            varied[key] = np.repeat(values, OFFSETS)
    done = loop.batch(REST_S, varied, record=())
    return np.asarray(1e3 * np.sqrt(np.mean(done.metrics["chatter"].reshape(-1, OFFSETS) ** 2, axis=1)))


def _value(block: Block, key: str) -> float:
    found: Any = block.params
    for name in key.split("."):
        found = getattr(found, name)
    return float(found)


@measure
def proofs(lab: Lab) -> list[Certificate]:
    """The law under every load and command: on the nominal plant, then on the four of the box with the largest gain."""
    return [driven(around_large(SPLIT, plant), (0.0, 1.0)) for plant in ({}, *box_plants()[-4:])]


class Response(NamedTuple):
    """The table's sampled response, with its dead time."""

    z: np.ndarray
    table: np.ndarray
    lines_z: np.ndarray
    lines_table: np.ndarray
    box: list[np.ndarray]
    """That of every plant of the robustness box."""


@lru_cache(maxsize=1)
def response() -> Response:
    """On a grid for Ms, and at the lines of Table II."""
    gain = pid(kp=1.0, ki=0.0, kd=0.0)
    plain = opened(gain)
    w = np.unique(np.concatenate([np.geomspace(1.0, 1500.0, 200), np.linspace(200.0, np.pi / PERIOD_S, 400)]))
    lines = 2.0 * np.pi * np.array(LINES_HZ)
    box = [opened(gain, changes).response(w) for changes in box_plants()]
    at_lines = np.exp(1j * lines * PERIOD_S), plain.response(lines)
    return Response(np.exp(1j * w * PERIOD_S), plain.response(w), *at_lines, box)


def law(gains: np.ndarray, z: np.ndarray) -> np.ndarray:
    """``C(z)`` of a parallel PID: kp, ki, kd, filter_s."""
    kp, ki, kd, lag = gains
    return np.asarray(kp + ki * PERIOD_S * z / (z - 1.0) + kd * (z - 1.0) / ((lag + PERIOD_S) * z - lag))


def peak(gains: np.ndarray) -> float:
    """Ms of a PID on the grid."""
    at = response()
    return float((1.0 / np.abs(1.0 + law(gains, at.z) * at.table)).max())


def linear_rows(gains: np.ndarray) -> np.ndarray:
    """Rows of Table II of a linear PID, um, three speeds by five lines: a linear loop scales the table's PID column."""
    at = response()
    table_i = np.array([pid.params.kp, pid.params.ki, pid.params.kd, 0.0])
    ratio = np.abs((1.0 + law(table_i, at.lines_z) * at.lines_table) / (1.0 + law(gains, at.lines_z) * at.lines_table))
    return np.asarray(np.array(list(PID_UM.values())) * ratio)


def best_linear(lab: Lab, ms: float = MS, du_mv: float = REST_DU_MV, seed: int = 1, rounds: int = 60) -> Block:
    """The PID with the smallest mean row of Table II under both bounds, by differential evolution (seeded)."""
    from scipy.optimize import differential_evolution

    def worth(x: np.ndarray) -> np.ndarray:
        gains = np.exp(x)
        over = np.array([max(0.0, peak(g) / ms - 1.0) for g in gains.T])
        tame = over < 1.0
        du = np.full(len(over), np.inf)
        if tame.any():
            du[tame] = rest_du_mv(lab, [_pid(g) for g in gains.T[tame]])
        score = np.array([linear_rows(g).mean() for g in gains.T])
        loud = np.where(np.isfinite(du), np.maximum(0.0, du / du_mv - 1.0), 10.0)
        return np.asarray(score + 5.0 * over + 5.0 * loud)

    bounds = [tuple(np.log(b)) for b in ((0.05, 5.0), (1e-3, 1e3), (1e-5, 2e-2), (1e-6, 5e-3))]
    found = differential_evolution(worth, bounds, rng=seed, maxiter=rounds, popsize=12, tol=1e-8, polish=False,
                                   vectorized=True, updating="deferred")  # fmt: skip
    return _pid(np.exp(found.x))


def _pid(gains: np.ndarray) -> Block:
    return pid(**dict(zip(("kp", "ki", "kd", "filter_s"), map(float, gains), strict=True)))


def split_of(gains: np.ndarray) -> Block:
    """An npid_split of nine numbers: quiet and firm kp, ki, kd, filter_s, then es_um."""
    keys = [f"{path}.{name}" for path in ("quiet", "firm") for name in ("kp", "ki", "kd", "filter_s")]
    return npid_split.using(**dict(zip([*keys, "es_um"], map(float, gains), strict=True)))


def gains_of(block: Block) -> np.ndarray:
    """The nine numbers of an npid_split."""
    p = block.params
    return np.array([*p.quiet, *p.firm, p.es_um])


def split_peak(gains: np.ndarray) -> float:
    """Largest Ms of an npid_split over the slopes of ``large``, on the grid."""
    at = response()
    quiet, firm = law(gains[:4], at.z) * at.table, law(gains[4:8], at.z) * at.table
    return max(float((1.0 / np.abs(1.0 + quiet + s * (firm - quiet))).max()) for s in SHARES)


def split_room(gains: np.ndarray) -> float:
    """Upper slope of ``large`` up to which the circle criterion holds on all the box, by the grid; the law needs 1."""
    at = response()
    quiet, firm = law(gains[:4], at.z), law(gains[4:8], at.z)
    least = min(float(((firm - quiet) * table / (1.0 + quiet * table)).real.min()) for table in at.box)
    return -1.0 / least if least < 0.0 else float("inf")


def searched(
    lab: Lab, start: Block = SPLIT, ms: float = MS, du_mv: float = REST_DU_MV, room: float = 1.1, tries: int = 500,
    seed: int = 1, progress: Callable[[float], None] = lambda _: None,
) -> Block:  # fmt: skip
    """A random search from ``start`` for smaller rows, with and without the spindle's lines, under both bounds."""
    base = linear_rows(np.array([LINEAR.params.kp, LINEAR.params.ki, LINEAR.params.kd, LINEAR.params.filter_s]))

    def worth(gains: np.ndarray) -> float:
        over = max(0.0, split_peak(gains) / ms - 1.0) + max(0.0, room / split_room(gains) - 1.0)
        if over > 1.0:
            return 10.0 + over
        block = split_of(gains)
        loud = max(0.0, float(rest_du_mv(lab, [block])[0]) / du_mv - 1.0)
        cut = tried(lab, block, draws=1, encoder=False).rows / base
        free = tried(lab, block, draws=1, encoder=False, spindle=False).rows / base
        return float(np.mean(cut) + 0.5 * np.mean(free)) + 5.0 * (over + loud)

    draw, width = np.random.default_rng(seed), 0.15
    best = np.log(gains_of(start))
    score = worth(np.exp(best))
    for _ in range(tries):
        candidate = best + width * draw.normal(size=9) * (draw.random(9) < 0.5)
        found = worth(np.exp(candidate))
        better = found < score
        best, score = (candidate, found) if better else (best, score)
        width = min(1.3 * width, 0.5) if better else max(0.985 * width, 0.01)
        progress(score)
    return split_of(np.exp(best))
