"""The study ``sofnn_tangent``: a fuzzy neural network that learns to keep a blade on its tangent while it cuts."""

from __future__ import annotations

from pathlib import Path

from leadscrew.studies.evaluating import evaluation_of
from leadscrew.studies.sofnn_tangent.controllers import CONTROLLERS
from leadscrew.studies.sofnn_tangent.runs import build
from leadscrew.studies.sofnn_tangent.scenarios import SCENARIOS
from leadscrew.studies.study import Study

STUDY = Study(
    name="sofnn_tangent",
    title="Tangent following in flexible material with a self-organising fuzzy neural network",
    paper=(
        "Yaohua Deng, Xiali Liu, Liming Wu, Qiaofen Zhang: Study of Self-organizing Fuzzy Neural Network Control for "
        "Flexible Material Path Processing Tangent Following Error Compensation. Guangdong University of Technology, "
        "Guangzhou."
    ),
    controllers=CONTROLLERS,
    scenarios=SCENARIOS,
    build=build,
    evaluate=evaluation_of("sofnn_tangent"),
    folder=Path(__file__).parent,
    summary=(
        "A performance network corrects the rules of a fuzzy network while a blade cuts. It learns, and beats fixed "
        "rules; a tuned PID equals it. Feed-forward of the curvature, and learning from piece to piece, which composes "
        "with the network, are three times better."
    ),
)
