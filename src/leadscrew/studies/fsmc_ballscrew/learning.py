"""Learning from pass to pass: the observer's torque of one pass becomes feed-forward of the next.

A pass starts as every sine of the study does, in steady sliding on the command, runs for :data:`SETTLED` and one period
more, and is judged over that period. Learned is the load ``d`` of the disturbance observer (*ILC of d* in the project's
digest), by :func:`leadscrew.analysis.trial_learning.taught`: four samples ahead, smoothed over two, with a gain of 0.7.
The error itself could be learned from as well; ``d`` is in N m already and needs no gain of its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from leadscrew.analysis.trial_learning import last_period, taught
from leadscrew.controllers.feed_forward_table import feed_forward_table
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.runs import ENCODER_NM, PERIOD_S, Loops
from leadscrew.studies.fsmc_ballscrew.scenarios import SCENARIOS, SineMove

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block

FIXED, SCHEDULED = "ours.pd_dob_fixed", "ours.pd_dob"
"""Without and with gains that rise at low speed."""

SETTLED = 0.1
"""Seconds before the judged period: the start does not count, there the believed viscous friction is 3 N m too much."""

TOLERANCES: Mapping[str, Any] = {"rtol": 1e-3, "atol": 1e-8}
"""Enough where the stage slides: on sin 2 pi t no error changes by more than 3 nm with less. With fixed gains on the
slower sines a pass is chance with less as well."""

NO_DAMPING = {"controller.inner.hat.damping": 0.0}
"""A believed friction without sigma_1, as the digest has it on 5 sin t."""

HIGH_GAIN = {"controller.inner.kp": 1000.0}


class Learned(NamedTuple):
    """What is known of a series of passes: largest errors in um, and the table of the next pass."""

    errors: list[float]
    table: np.ndarray


_kept: WeakKeyDictionary[Loops, dict[Any, Learned]] = WeakKeyDictionary()


@cache
def with_table(count: int) -> Block:
    """A controller with a table of ``count`` values, one for each size: those of one size share a program."""
    return feed_forward_table(CONTROLLERS[FIXED], np.zeros(count))


def period_of(scenario: str) -> float:
    """One period of a sine, in s."""
    sine = SCENARIOS[scenario].params
    assert isinstance(sine, SineMove)
    return 2.0 * math.pi / sine.rate_rad_s


def passes(
    loops: Loops, base: str, scenario: str, count: int = 15, changes: Mapping[str, Any] | None = None,
    encoder_nm: float = ENCODER_NM,
) -> list[float]:  # fmt: skip
    """Largest true error over a period, in um, after 0, 1, ... ``count`` passes of learning; each pass is made once."""
    period = period_of(scenario)
    size = round(period / PERIOD_S)
    key = (base, scenario, tuple(sorted((changes or {}).items())), encoder_nm)
    known = _kept.setdefault(loops, {})
    block = with_table(size)
    assert block.params is not None
    done = known.setdefault(key, Learned([], np.zeros(size)))
    while len(done.errors) <= count:
        given = block.params._replace(inner=CONTROLLERS[base].params, table=done.table, period_s=period)
        run = loops.run(
            replace(block, params=given), scenario, SETTLED + period, record=("true_error", "controller.inner.load"),
            changes=changes, encoder_nm=encoder_nm, **TOLERANCES,
        )  # fmt: skip
        worst = float(np.abs(last_period(run.time, run["true_error"], period, size)).max())
        table = taught(done.table, last_period(run.time, run["controller.inner.load"], period, size))
        done = known[key] = Learned([*done.errors, 1e3 * worst], table)
    return done.errors[: count + 1]
