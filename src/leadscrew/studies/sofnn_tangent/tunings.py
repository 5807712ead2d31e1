"""Ready controllers for the study ``sofnn_tangent``, by name. A period of 10 ms, at 50 mm/s, is meant.

``paper.`` and ``corrected.`` have the paper's scales, ``m_c = m = 4``, no safeguard but clamp and
cap. ``paper.`` has the network, as the paper does, or is a literal reading of it that does not work; ``corrected.`` has
the table between its cells, or does not learn. ``ours.`` are tuned, with all safeguards.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.controllers._sofnn.network import fnn, sofc, sofnn
from leadscrew.controllers._sofnn.rules import with_network, with_rules
from leadscrew.controllers._tangent.curvature_feed_forward import curvature_feed_forward
from leadscrew.controllers._tangent.curvature_network import apart_covariance, curvature_network
from leadscrew.controllers._tangent.tangent_dob import tangent_dob
from leadscrew.kernel.block import Block
from leadscrew.neural.inference_net import initial_rules
from leadscrew.neural.performance import Performance

LITERAL: dict[str, Any] = {"delay": 4, "leak": 0.0, "freeze": False}
"""What all with the paper's scales have."""
TUNED: dict[str, Any] = {"k_e": 6.0 / 45.0, "target": "accumulate", "kg": 0.7}
"""Twice the gain of the deviation, every correction added."""


def _read_bad_slope() -> Performance:
    kept = json.loads((Path(__file__).parent / "data" / "bad_slope.json").read_text(encoding="utf-8"))
    return Performance(np.array(kept["hidden"]), np.zeros(len(kept["out"])), np.array(kept["out"]))


BAD_SLOPE = _read_bad_slope()
"""A network of 18 weights that fits Table 1 better than the safe one (0.594 levels) and has the wrong sign between the
cells around the origin: least squares from 60 starts, the best. For demonstration: it drives the knife to its limit."""

TUNINGS: dict[str, Block] = {
    "paper.sofnn_pnn": sofnn(source="network", **LITERAL),
    "paper.sofnn_rounded": sofnn(source="table_rounded", **LITERAL),
    "paper.sofnn_no_prior": with_rules(sofnn(source="network", **LITERAL), np.zeros(49)),
    "paper.sofnn_bad_slope": with_network(sofnn(**LITERAL), BAD_SLOPE),
    "corrected.sofnn_table": sofnn(**LITERAL),
    "corrected.sofnn_odd": sofnn(source="table_odd", **LITERAL),
    "corrected.fnn": fnn,
    "corrected.fnn_15": fnn(k_e=6.0 / 15.0),
    "corrected.fuzzy": fnn(rules=initial_rules().ravel()),
    "corrected.sofc": sofc(**LITERAL),
    "corrected.sofc_stored": sofc(target="stored", **LITERAL),
    "corrected.sofnn_accumulate": sofnn(target="accumulate", **LITERAL),
    "ours.sofnn_tuned": sofnn(**TUNED),
    "ours.sofnn_nlms": sofnn(learner="nlms", **TUNED),
    "ours.sofc_tuned": sofc(k_e=6.0 / 45.0, kg=0.7),
}
"""``fnn`` and ``fnn_15`` (levels per 15 deg), ``fuzzy`` with untrained rules; ``sofnn_pnn``, ``_table``, ``_odd`` and
``_rounded`` by the source of the correction, ``_no_prior`` starts from no rules, ``_bad_slope`` has :data:`BAD_SLOPE`,
``_accumulate`` adds every correction; ``sofc`` is the baseline, ``sofc_stored`` in the form of 1979; ``sofnn_tuned``,
``sofnn_nlms`` and ``sofc_tuned`` have more gain."""

CURVATURE: dict[str, Block] = {
    "ours.tangent_dob": tangent_dob,
    "ours.curvature_feed_forward": curvature_feed_forward,
    "ours.curvature_network": curvature_network,
    "ours.curvature_rules": curvature_network(
        prior_covariance=apart_covariance(), k_c=36.0, k_h=36.0, highpass_s=0.03, gain=0.0
    ),
}
"""Beside the networks of the paper, for a delay of the camera of 0.04 s and a preview of one sample: a disturbance
observer, learned and planned feed-forward of the curvature, and rules that learn alone."""
