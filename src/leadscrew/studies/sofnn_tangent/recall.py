"""Recall: rules of the curvature that learn on one line, are frozen, and cut that line and others again (M4)."""

from __future__ import annotations

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from leadscrew.controllers.tangent.curvature_network import apart_covariance, curvature_network, start_covariance
from leadscrew.kernel.block import Block
from leadscrew.neural.inference_net import CLAMP, RULES
from leadscrew.studies.sofnn_tangent.lines import LAPS, MATERIAL_NAMES, line
from leadscrew.studies.sofnn_tangent.pieces import Learned, pieces
from leadscrew.studies.sofnn_tangent.runs import Loops

LESSONS = 5
"""Pieces that are learned from."""
RUNS = {"digest": 3, "ours": 4, "no_direction": 2, "rules_apart": 2}
"""By form; each run is a set of textures and noises of its own."""
LINES = tuple(LAPS)


class Recall(NamedTuple):
    """RMS deviations of what was learned on one line, deg; materials and runs last."""

    none: np.ndarray
    """Of no compensation, ``[line, material, run]``."""
    learning: np.ndarray
    """In the last lesson, ``[line, material, run]``."""
    frozen: np.ndarray
    """Frozen, with new textures: ``[line of the lessons, line, material, run]``."""

    def kept(self) -> np.ndarray:
        """Share of the gain that is kept on the line of the lessons, ``[line, material]``."""
        same = np.array([self.frozen[i, i] for i in range(len(LINES))]).mean(axis=-1)
        none = self.none.mean(axis=-1)
        return np.asarray((none - same) / (none - self.learning.mean(axis=-1)))

    def same(self) -> np.ndarray:
        """RMS on the line of the lessons, ``[line, material]``."""
        return np.array([self.frozen[i, i] for i in range(len(LINES))]).mean(axis=-1)

    def worst(self) -> np.ndarray:
        """Largest RMS on the other lines by run, deg."""
        other = self.frozen[~np.eye(len(LINES), dtype=bool)]
        return np.asarray(other.max(axis=(0, 1)))

    def elsewhere(self) -> np.ndarray:
        """RMS on the other lines, ``[line of the lessons, line, material]``; NaN on its own."""
        found = self.frozen.mean(axis=-1).copy()
        for i in range(len(LINES)):
            found[i, i] = np.nan
        return found


def digest_rules(name: str) -> Block:
    """The digest's form: every rule for itself, no direction; levels reach to the sharpest curve of the lessons."""
    scale = CLAMP / float(np.abs(line(name).curvature).max())
    return curvature_network(prior_covariance=apart_covariance(), k_c=scale, k_h=scale, highpass_s=0.06, gain=0.0)


def ours(name: str) -> Block:
    """Rules that know of each other, and the direction: the same on every line; no observer."""
    return curvature_network(gain=0.0)


def no_direction(name: str) -> Block:
    """Ours without the terms of the direction."""
    return curvature_network(gain=0.0, prior_covariance=start_covariance(direction=0.0))


def rules_apart(name: str) -> Block:
    """Ours with rules that do not know of each other."""
    start = apart_covariance()
    start[RULES:, RULES:] = start_covariance()[RULES:, RULES:]
    return curvature_network(gain=0.0, prior_covariance=start)


FORMS = {"digest": digest_rules, "ours": ours, "no_direction": no_direction, "rules_apart": rules_apart}
_KEPT: WeakKeyDictionary[Loops, dict[str, Recall]] = WeakKeyDictionary()


def recall(loops: Loops, form: str) -> Recall:
    """All lessons and replays of a form, cut once for some loops: ours in all materials, the others in fabric."""
    kept = _KEPT.setdefault(loops, {})
    if form not in kept:
        materials, runs = (MATERIAL_NAMES if form == "ours" else ("fabric",)), RUNS[form]
        learning, frozen = [], []
        for name in LINES:
            block = FORMS[form](name)
            taught = pieces(loops, block, LESSONS, carry=True, runs=runs, lines=(name,), materials=materials)
            start = Learned(dict.fromkeys(LINES, taught.learned.prior[name]), {})
            again = pieces(loops, block(learning=0), 1, runs=runs, materials=materials, start=start, first=LESSONS)
            learning.append(taught.rms[-1, 0])
            frozen.append(again.rms[0])
        none = pieces(loops, "paper.uncompensated", 1, runs=runs, materials=materials, first=LESSONS)
        kept[form] = Recall(none.rms[0], np.array(learning), np.array(frozen))
    return kept[form]
