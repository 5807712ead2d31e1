"""All claims of the study, topic by topic, in the order in which the report tells its story."""

from __future__ import annotations

from collections.abc import Callable

from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.claims_change import change_claims
from leadscrew.studies.sofnn_tangent.claims_comparison import comparison_claims
from leadscrew.studies.sofnn_tangent.claims_contour import contour_claims
from leadscrew.studies.sofnn_tangent.claims_delay import delay_claims
from leadscrew.studies.sofnn_tangent.claims_errata import errata_claims
from leadscrew.studies.sofnn_tangent.claims_feed_forward import feed_forward_claims
from leadscrew.studies.sofnn_tangent.claims_inference import inference_claims
from leadscrew.studies.sofnn_tangent.claims_moonshots import moonshots_claims
from leadscrew.studies.sofnn_tangent.claims_online import online_claims
from leadscrew.studies.sofnn_tangent.claims_paper import paper_claims
from leadscrew.studies.sofnn_tangent.claims_performance import performance_claims
from leadscrew.studies.sofnn_tangent.claims_performance_training import performance_training_claims
from leadscrew.studies.sofnn_tangent.claims_pieces import pieces_claims
from leadscrew.studies.sofnn_tangent.claims_plant import plant_claims
from leadscrew.studies.sofnn_tangent.claims_recall import recall_claims
from leadscrew.studies.sofnn_tangent.claims_sight import sight_claims
from leadscrew.studies.sofnn_tangent.claims_signals import signals_claims
from leadscrew.studies.sofnn_tangent.claims_workflow import workflow_claims
from leadscrew.studies.sofnn_tangent.results import Results
from leadscrew.studies.sofnn_tangent.runs import Loops

Topics = list[tuple[str, list[Claim]]]


def topics(found: Results, progress: Callable[[str, float], None]) -> Topics:
    """Every claim, judged, below its heading."""
    asked: list[tuple[str, Callable[[Loops], list[Claim]]]] = [
        ("What the paper prints", paper_claims),
        ("The correction table and the performance network", performance_claims),
        ("Training the performance network", performance_training_claims),
        ("The fuzzy network and its Kalman filter", inference_claims),
        ("The process", plant_claims),
        ("Signals and scales", signals_claims),
        ("Three lines in three materials", comparison_claims),
        ("Where the cut is", contour_claims),
        ("The material changes", change_claims),
        ("Delay", delay_claims),
        ("Learning that goes on", online_claims),
        ("The camera loses the cut", sight_claims),
        ("What learned rules are worth", recall_claims),
        ("What the paper has wrong", errata_claims),
        ("Feed-forward and observer", feed_forward_claims),
        ("Piece after piece", pieces_claims),
        ("From a drawing to a program, and back", workflow_claims),
        ("Moonshots", moonshots_claims),
    ]
    judged: Topics = []
    for number, (title, claims) in enumerate(asked):
        progress(title, number / len(asked))
        judged.append((title, claims(found.loops)))
    return judged
