"""Rules and a performance network given to a self-organising controller; rules shifted for a bumpless start."""

from __future__ import annotations

from typing import Any

import numpy as np

from leadscrew.controllers._sofnn.levels import MOST_LEVEL
from leadscrew.kernel.block import Block
from leadscrew.neural.inference_net import network_output
from leadscrew.neural.performance import Performance
from leadscrew.util.errors import BlockError, ValueRefused


def consequents(rules: Any) -> np.ndarray:
    """49 consequents in a row, from 49 or from 7 x 7 (rows EC, columns E, from NB).

    Raises:
        ValueRefused: another number of them, or one that is not between -6 and 6 levels.
    """
    w = np.array(rules, dtype=float)
    if w.shape not in ((49,), (7, 7)):
        raise ValueRefused(f"rules of shape {w.shape} (sofnn): expected 49 in a row or 7 x 7")
    if not (np.abs(w) <= MOST_LEVEL).all():
        raise ValueRefused(f"rules from {w.min():g} to {w.max():g} (sofnn): expected -6 to 6 levels")
    return w.ravel()


def with_rules(block: Block, rules: Any, prior: bool = True, variance: float | None = None) -> Block:
    """A self-organising controller that starts from ``rules``: learned ones, other ones, none (zeros).

    ``prior``: they are also what the leak goes back to and what a bumpless start begins with; else the block's own
    prior stays that. ``variance``: of each consequent at the start, levels squared (1 unless told).

    Raises:
        ValueRefused: not 49 rules between -6 and 6 levels, or a variance that is not above 0.
        BlockError: a controller without rules that learn.
    """
    if not hasattr(block.state, "weights") or not hasattr(block.params, "prior"):
        raise BlockError(f"with_rules({block.name}): has no rules that learn; the rules of fnn are its parameter rules")
    w = consequents(rules)
    made = block(prior=w) if prior else block
    if variance is None:
        return made.starting(weights=w)
    if not variance > 0.0:
        raise ValueRefused(f"variance = {variance!r} (with_rules): expected more than 0 levels squared")
    if not hasattr(block.state, "covariance"):
        raise BlockError(f"with_rules({block.name}): its rules have no variance")
    return made.starting(weights=w, covariance=variance * np.eye(w.size))


def with_network(block: Block, net: Performance) -> Block:
    """A self-organising controller that takes its corrections from the performance network ``net``.

    :mod:`leadscrew.neural.safety` tells a network that would drive the loop the wrong way.

    Raises:
        BlockError: a controller without a performance measure.
    """
    if not hasattr(block.params, "net"):
        raise BlockError(f"with_network({block.name}): has no performance measure")
    return block(source="network", **{f"net.{key}": value for key, value in net._asdict().items()})


def shifted(weights, here, level, clamp):
    """Moves the four rules that fire so that they say ``level``, in place; for a step.

    All four by the same, or, where one would pass the clamp, drawn together around ``level`` as far as is needed.
    """
    k = 7 * here.j + here.i
    now = network_output(weights, here)
    share = 1.0
    for m in range(4):
        i = k + (m if m < 2 else m + 5)
        away = weights[i] - now
        room = clamp - level if away > 0.0 else clamp + level
        share = min(share, max(room, 0.0) / abs(away)) if abs(away) > 1e-12 else share
    for m in range(4):
        i = k + (m if m < 2 else m + 5)
        weights[i] = min(max(level + share * (weights[i] - now), -clamp), clamp)
    return share
