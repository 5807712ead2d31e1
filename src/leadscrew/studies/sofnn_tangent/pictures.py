"""All pictures of the study, in the order of the claims' topics."""

from __future__ import annotations

from leadscrew.studies.sofnn_tangent.figures_comparison import comparison_pictures
from leadscrew.studies.sofnn_tangent.figures_delay import delay_pictures
from leadscrew.studies.sofnn_tangent.figures_feed_forward import feed_forward_pictures
from leadscrew.studies.sofnn_tangent.figures_inference import inference_pictures
from leadscrew.studies.sofnn_tangent.figures_online import online_pictures
from leadscrew.studies.sofnn_tangent.figures_paper import paper_pictures
from leadscrew.studies.sofnn_tangent.figures_performance import performance_pictures
from leadscrew.studies.sofnn_tangent.figures_pieces import pieces_pictures
from leadscrew.studies.sofnn_tangent.figures_workflow import workflow_pictures
from leadscrew.studies.sofnn_tangent.results import Results
from leadscrew.studies.study import Picture


def all_pictures(found: Results) -> list[Picture]:
    """The paper's figures redrawn, then what lies beyond it."""
    made = (
        paper_pictures, performance_pictures, inference_pictures, comparison_pictures, delay_pictures, online_pictures,
        feed_forward_pictures, pieces_pictures, workflow_pictures,
    )  # fmt: skip
    return [picture for pictures in made for picture in pictures(found.loops)]
