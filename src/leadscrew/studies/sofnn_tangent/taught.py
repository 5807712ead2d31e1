"""The series of pieces that claims and pictures need, each cut once; and what other materials say of a new one."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from weakref import WeakKeyDictionary

import numpy as np

from leadscrew.controllers.sofnn.tunings import TUNINGS as SOFNN
from leadscrew.controllers.tangent.curvature_feed_forward import COUNT, START, curvature_feed_forward
from leadscrew.kernel.block import Block
from leadscrew.studies.sofnn_tangent.lines import FEED, LAPS, MATERIAL_NAMES
from leadscrew.studies.sofnn_tangent.pieces import MISMATCH, Learned, Pieces, Teaching, pieces
from leadscrew.studies.sofnn_tangent.runs import Loops

FALLING = (1.0, 0.9, 0.5, 0.4, 0.3)
"""Gains of the table from piece to piece: what is learned later has more pieces behind it."""
PLAIN = Teaching()
"""The digest's."""
BEST = Teaching(gains=FALLING)
WIDE = Teaching(width=4.0)
"""The digest's without feedback."""
NET, TUNED = "paper.sofnn_pnn", "ours.sofnn_tuned"
SWAP_AT = 5
"""Piece from which the flower is cut in foam instead of fabric."""
NOISE_BEFORE = 50
"""Pieces of noise that what other materials say does not share with what is judged."""

HELD = curvature_feed_forward(before=1)
"""The digest's start: the curvature before the line is that of the first sample."""
DIGEST = HELD(prior_covariance=np.eye(COUNT))


FEEDS = (20.0, 50.0, 100.0)
"""mm/s"""
STARTS = (0.03, 10.0)
"""deg^2"""


def at_the_feed(feed: float, loops: Loops, by_sample: bool = False) -> Pieces:
    """Two pieces of the flower in fabric by feed-forward at a feed; ``by_sample`` as in ``changing.fed``."""
    length = loops.asked("flower_fabric").params.texture_mm * (feed / FEED if by_sample else 1.0)
    return pieces(loops, DIGEST, 2, carry=True, lines=("flower",), materials=("fabric",), feed=feed,
                  changes={"disturbance.length": length})  # fmt: skip


def started_with(variance: float, loops: Loops) -> Pieces:
    """The first flower in fabric by feed-forward that starts from this variance of its weights, hardly capped."""
    block = HELD(prior_covariance=variance * np.eye(COUNT), trace_cap=1e3)
    return pieces(loops, block, 1, lines=("flower",), materials=("fabric",))


def flower(loops: Loops, controller: str | Block | None, count: int, teaching: Teaching | None, carry: bool) -> Pieces:
    """The flower in fabric, and in foam from :data:`SWAP_AT` on."""
    return pieces(loops, controller, count, teaching, carry, lines=("flower",), materials=("fabric",),
                  swap=(SWAP_AT, "foam"))  # fmt: skip


SERIES: dict[str, Callable[[Loops], Pieces]] = {
    "feed_forward": lambda k: pieces(k, curvature_feed_forward, 3, carry=True),
    "feed_forward_digest": lambda k: pieces(k, DIGEST, 3, carry=True),
    "feed_forward_preview_3": lambda k: pieces(k, ahead(2), 3, carry=True, runs=2, changes={"reference.preview": 2}),
    "feed_forward_preview_4": lambda k: pieces(k, ahead(3), 3, carry=True, runs=2, changes={"reference.preview": 3}),
    **{f"feed_forward_at_{feed:g}": partial(at_the_feed, feed) for feed in FEEDS},
    "feed_forward_slow_by_sample": partial(at_the_feed, FEEDS[0], by_sample=True),
    **{f"feed_forward_start_{p0:g}": partial(started_with, p0) for p0 in STARTS},
    "table_wide": lambda k: pieces(k, None, 6, WIDE),
    "table": lambda k: pieces(k, None, 6, PLAIN),
    "net_table": lambda k: pieces(k, SOFNN[NET], 6, PLAIN),
    "net_table_best": lambda k: pieces(k, SOFNN[NET], 6, BEST),
    "tuned_table": lambda k: pieces(k, SOFNN[TUNED], 3, PLAIN),
    "net_textbook": lambda k: pieces(k, SOFNN[NET], 6, Teaching(textbook=True), lines=("flower",),
                                     materials=("fabric",)),
    "swap_table": lambda k: flower(k, None, 8, PLAIN, False),
    "swap_tuned_table": lambda k: flower(k, SOFNN[TUNED], 8, PLAIN, False),
    "swap_feed_forward": lambda k: flower(k, HELD, 8, None, True),
    "mismatch_fixed": lambda k: pieces(k, SOFNN["corrected.fnn"], 1, changes=MISMATCH),
    "mismatch_tuned": lambda k: pieces(k, SOFNN[TUNED], 1, changes=MISMATCH),
    "mismatch_pid": lambda k: pieces(k, "ours.pid", 1, changes=MISMATCH),
    "mismatch_feed_forward": lambda k: pieces(k, HELD, 3, carry=True, changes=MISMATCH),
    "mismatch_table": lambda k: pieces(k, None, 3, WIDE, changes=MISMATCH),
    "mismatch_net_table": lambda k: pieces(k, SOFNN[NET], 6, PLAIN, changes=MISMATCH),
    "prior": lambda k: with_prior(k, None),
    "mismatch_prior": lambda k: with_prior(k, MISMATCH),
}  # fmt: skip
"""By name; the mean of five runs of nine cells unless the series says otherwise."""

_KEPT: WeakKeyDictionary[Loops, dict[str, Pieces]] = WeakKeyDictionary()


def series(loops: Loops, name: str) -> Pieces:
    """A series, cut once for some loops."""
    kept = _KEPT.setdefault(loops, {})
    if name not in kept:
        kept[name] = SERIES[name](loops)
    return kept[name]


def ahead(preview: int) -> Block:
    """The digest's feed-forward with another preview."""
    return DIGEST(preview=preview)


def others_say(loops: Loops, material: str, line: str, changes: dict[str, float] | None) -> np.ndarray:
    """Mean of the weights that two pieces of each of the other two lines have taught in the other two materials."""
    found = []
    for other in MATERIAL_NAMES:
        if other != material:
            learned = known_of(loops, other, changes)
            found.append(np.mean([learned.prior[o].mean(axis=0) for o in LAPS if o != line], axis=0))
    return np.asarray(np.mean(found, axis=0))


_KNOWN: WeakKeyDictionary[Loops, dict[tuple[str, bool], Learned]] = WeakKeyDictionary()


def known_of(loops: Loops, material: str, changes: dict[str, float] | None) -> Learned:
    """What two pieces of each line teach in a material, in textures and noise that no claim uses."""
    kept = _KNOWN.setdefault(loops, {})
    key = material, changes is None
    if key not in kept:
        cut = pieces(loops, curvature_feed_forward, 2, carry=True, runs=2, materials=(material,), changes=changes,
                     first=NOISE_BEFORE)  # fmt: skip
        kept[key] = cut.learned
    return kept[key]


def with_prior(loops: Loops, changes: dict[str, float] | None) -> Pieces:
    """The first piece of each line in each material, by a feed-forward that has seen neither line nor material."""
    runs = 5
    weights = {
        line: np.repeat([others_say(loops, m, line, changes) for m in MATERIAL_NAMES], runs, axis=0) for line in LAPS
    }
    start = Learned(weights, {})
    block = curvature_feed_forward(prior_covariance=START * np.eye(COUNT))
    return pieces(loops, block, 1, runs=runs, start=start, changes=changes)
