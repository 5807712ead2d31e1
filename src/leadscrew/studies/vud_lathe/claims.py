"""All claims of the study, topic by topic, in the order in which the report tells its story."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from leadscrew.report.claim import Claim
from leadscrew.studies.vud_lathe.claims_accuracy import accuracy_claims
from leadscrew.studies.vud_lathe.claims_arithmetic import arithmetic_claims
from leadscrew.studies.vud_lathe.claims_data import data_claims
from leadscrew.studies.vud_lathe.claims_design import design_claims, designed_claims
from leadscrew.studies.vud_lathe.claims_differentiator import differentiator_claims
from leadscrew.studies.vud_lathe.claims_fast import fast_claims
from leadscrew.studies.vud_lathe.claims_limits import limits_claims
from leadscrew.studies.vud_lathe.claims_motion import motion_claims
from leadscrew.studies.vud_lathe.claims_original import original_claims
from leadscrew.studies.vud_lathe.claims_positioning import positioning_claims
from leadscrew.studies.vud_lathe.claims_robustness import robustness_claims
from leadscrew.studies.vud_lathe.claims_sensor import sensor_claims
from leadscrew.studies.vud_lathe.claims_variants import variants_claims
from leadscrew.studies.vud_lathe.results import Results
from leadscrew.studies.vud_lathe.tables import Move

Topics = list[tuple[str, list[Claim]]]


def all_claims(runs: Mapping[str, Any], sweep: Any, moves: Mapping[str, Move]) -> list[Claim]:
    """The claims that need the paper's numbers and the runs of its own moves alone."""
    return [*arithmetic_claims(), *data_claims(moves), *motion_claims(runs, sweep, moves)]


def topics(found: Results, progress: Callable[[str, float], None]) -> Topics:
    """Every claim, judged, below its heading."""
    loops, moves = found.loops, found.moves
    asked: list[tuple[str, Callable[[], list[Claim]]]] = [
        ("The paper's arithmetic", arithmetic_claims),
        ("The paper's data: rules, units, gain of the axis", lambda: data_claims(moves)),
        ("Rules and curvature from the data", lambda: [*design_claims(moves), *designed_claims(loops)]),
        ("The differentiating circuit of Figure 5", lambda: differentiator_claims(loops)),
        ("The old servo", lambda: original_claims(loops, moves, found.original)),
        ("The moves of Figures 11 and 12", lambda: motion_claims(found.runs, found.sweep, moves)),
        ("Why the printed law creeps, and its variants", lambda: variants_claims(loops)),
        ("The grating ruler", sensor_claims),
        ("Sensor or controller", lambda: accuracy_claims(loops, found.errors)),
        ("Robustness and friction", lambda: robustness_claims(loops)),
        ("The motor's limits, and the shortest time", lambda: limits_claims(loops)),
        ("Near the shortest time", lambda: fast_claims(loops)),
        ("Positioning by ISO 230-2", lambda: positioning_claims(loops, found.positioning)),
    ]
    judged: Topics = []
    for number, (title, claims) in enumerate(asked):
        progress(title, number / len(asked))
        judged.append((title, claims()))
    return judged
