"""What the self-organising controllers share: where the correction comes from, what it refers to, when to learn.

    g(k) = kg P(E(k), EC(k)),     0 where abs(e) < dead_zone

``P`` is the performance measure (:mod:`leadscrew.neural.performance`): the table between its cells (``table``), its
nearest cell (``table_rounded``), the performance network (``network``), the odd part of the table (``table_odd``).
A deviation seen now was caused ``delay`` samples ago (``m_c``: measurement delay plus the lag of the axis, in samples),
so the rules that fired *then* are corrected.

**When nothing is learned**: in the first ``delay`` samples after the start and after the cut was lost from sight (what
fired then is not known); while the offset is at its limit and the correction would push it further (``freeze``); with
``learning`` off.

**Leak**: ``w += leak (prior - w)``, towards the rules from before, not towards zero.

Source: the paper of the study ``sofnn_tangent``, section 2 and steps (3) to (7); freeze, leak and dead zone are the
study's.
"""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple

import numpy as np

from leadscrew.controllers._sofnn.levels import MOST_LEVEL, ROOM, Watch, lacking, sent, watched
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.neural.performance import MOST, ODD, Performance, correction, looked_up

FULL = 0.99
"""An offset at this share of its limit is at the limit."""
NOTHING = np.zeros(ROOM)
"""What is known of the past after a bumpless start."""

Kg = Annotated[float, Ge(0), Le(1000), Doc("strength of the correction, kg")]
Source = Annotated[
    Literal["table", "table_rounded", "network", "table_odd"] | int, Doc("where the correction comes from")
]
Table = Annotated[np.ndarray, Ge(-MOST), Le(MOST), Doc("performance table, 13 x 13 levels, rows EC, columns E")]
Delay = Annotated[int, Ge(1), Le(ROOM - 1), Doc("samples by which a correction is referred back, m_c")]
DeadZone = Annotated[float, Unit("deg"), Ge(0), Le(90), Doc("a smaller deviation is not corrected")]
Leak = Annotated[float, Ge(0), Le(1), Doc("share by which the rules go back to the prior, a sample")]
Target = Annotated[Literal["stored", "accumulate"] | int, Doc("what the corrected rules are to reach")]
Clamp = Annotated[float, Gt(0), Le(MOST), Doc("largest consequent, either way, levels")]
Learning = Annotated[bool, Doc("whether the rules are changed; off holds what was learned")]
Freeze = Annotated[bool, Doc("no learning while the offset is at its limit and would be pushed further")]
Rules = Annotated[np.ndarray, Ge(-MOST_LEVEL), Le(MOST_LEVEL), Doc("49 consequents, levels; number 7 EC + E, from NB")]

Weights = Annotated[np.ndarray, Doc("49 consequents, levels; number 7 EC + E, from NB")]
PastE = Annotated[np.ndarray, Doc("E of the last samples, levels")]
PastEC = Annotated[np.ndarray, Doc("EC of the last samples, levels")]
PastD = Annotated[np.ndarray, Doc("level D of the rules in the last samples")]
At = Annotated[int, Doc("place of the next of them")]


class Measure(NamedTuple):
    """Performance measure and its use, as a step reads it."""

    kg: float
    source: int
    table: np.ndarray
    net: Performance
    delay: int
    dead_zone: float
    leak: float
    clamp: float
    learning: bool
    freeze: bool


class Seen(NamedTuple):
    """What a sample shows."""

    watch: Watch
    e: float
    """Deviation, levels."""
    ec: float
    """Its change, levels."""
    g: float
    """Correction, levels."""


class Answer(NamedTuple):
    """What a sample ends with."""

    offset: float
    short: float
    at: int


def measure(params) -> Measure:
    """The measure of a controller's parameters."""
    return Measure(
        params.kg, params.source, np.array(params.table, dtype=float), params.net, params.delay, params.dead_zone,
        params.leak, params.clamp, params.learning, params.freeze,
    )  # fmt: skip


def rectified(p, error, e, ec):
    """The correction ``g``, levels."""
    if p.source == ODD:
        raw = 0.5 * (looked_up(p.table, e, ec) - looked_up(p.table, -e, -ec))
    else:
        raw = correction(p.source, p.table, p.net, e, ec)
    return 0.0 if abs(error) < p.dead_zone else p.kg * raw


def seen(p, s, command, feedback):
    """What a sample shows."""
    watch = watched(p.scales, s.watch, command, feedback)
    e, ec = p.scales.k_e * watch.error, p.scales.k_ec * watch.rate
    return Seen(watch, e, ec, rectified(p.measure, watch.error, e, ec))


def learns(p, s, now):
    """Whether the rules are changed in this sample."""
    pushed = p.measure.freeze and abs(s.offset) >= FULL * p.scales.max_offset and now.g * s.offset > 0.0
    return p.measure.learning and now.watch.known > p.measure.delay and not pushed


def place_before(at, delay):
    """The place of ``delay`` samples ago."""
    return at - delay if at >= delay else at - delay + ROOM


def place_after(at):
    """The place of the next sample."""
    return at + 1 if at + 1 < ROOM else 0


def leak(weights, prior, share):
    """Moves the rules towards the prior, in place."""
    if share > 0.0:
        for i in range(weights.shape[0]):
            weights[i] = weights[i] + share * (prior[i] - weights[i])
    return share


def answered(p, s, now, level):
    """The offset for what the rules say; inputs and level go to the past, in place."""
    short = lacking(p.scales, s.watch.blind, s.aligned, s.short, level, s.offset)
    s.past_e[s.at] = now.e
    s.past_ec[s.at] = now.ec
    s.past_d[s.at] = level
    return Answer(sent(p.scales, now.watch, level, short, s.offset), short, place_after(s.at))
