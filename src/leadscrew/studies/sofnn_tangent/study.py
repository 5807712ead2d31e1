"""The study ``sofnn_tangent``: a fuzzy neural network that learns to keep a blade on its tangent while it cuts."""

from __future__ import annotations

from pathlib import Path

from leadscrew.studies.results import contents_of
from leadscrew.studies.sofnn_tangent.controllers import CONTROLLERS
from leadscrew.studies.sofnn_tangent.scenarios import SCENARIOS, build
from leadscrew.study_data import Assumption, Study

ASSUMED = (
    Assumption(
        "process",
        "shear of the material behind a lag, 14° at most; axis with a lag of 20 ms",
        "The paper gives none. The side load of a curve shears the material, which springs back behind a blade of "
        "3 mm; fibre and bevel turn the cut too.",
    ),
    Assumption(
        "materials",
        "fabric, leather, foam: 45, 25, 90° mm of shear, lags of 30, 20, 100 ms, gains of 0.95, 0.90, 0.75",
        "Believed, not measured: the range from stiff to soft.",
    ),
    Assumption(
        "line",
        "a B-spline wave of 462 mm, a flower of 395 mm, a rounded rectangle of 303 mm",
        "The paper's Figure 5 shows one curve without numbers.",
    ),
    Assumption(
        "texture, camera",
        "0.25° over 3 mm; a camera 2 mm behind the blade, 0.15° of noise",
        "The paper says neither how the cut is seen nor how repeatable the material is.",
    ),
    Assumption(
        "sampling time and feed", "10 ms, 50 mm/s", "Not printed. A sample is 0.5 mm, a tenth of the sharpest radius."
    ),
    Assumption("delay m of (3)", "4 samples in the paper's networks", "Not printed. It is the camera's delay."),
    Assumption(
        "unit of ec",
        "degrees a sample",
        "Printed without a unit of time. In degrees a second the loop swings with a camera that is one sample late.",
    ),
    Assumption(
        "sign of e",
        "actual less wanted angle",
        "The text names the reference first; area I of Figure 4 (too low, E = NM) asks for this order.",
    ),
    Assumption(
        "positive direction",
        "counter-clockwise, of angles and offset",
        "The paper prints clockwise. A mirrored line gives the same deviations; counter-clockwise is usual for G-code.",
    ),
    Assumption(
        "rules at the start",
        "the set of E plus that of EC, trained on Mamdani's answers at 169 points",
        "The paper gives neither rules nor samples. Its Figure 2 has 49 rules.",
    ),
    Assumption(
        "membership functions",
        "seven triangles that cross at one half",
        "Figure 3 is missing in the text that we have.",
    ),
    Assumption(
        "Kalman filter",
        "variance of a target 0.01, walk of 0.05 a sample, variance 4 at most, rules within ±6 levels",
        "The paper gives none. Without a walk the learning stops, without a limit the covariance grows.",
    ),
    Assumption(
        "performance network",
        "18 weights by genetic algorithm and least squares, accepted only with the right sign and slope at the origin",
        "The paper prints no weights; the network of the smallest RMSE drives the blade away.",
    ),
    Assumption("J", "half the squared innovation", "Not defined in the paper."),
    Assumption(
        "plant that no controller knows of",
        "softening 12, four-fold 0.7°, ripple 0.5°, hysteresis 0.3°",
        "Chosen so that a wrong model costs something: terms that feed-forward cannot say.",
    ),
)

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
    folder=Path(__file__).parent,
    contents=contents_of(*(f"leadscrew.studies.sofnn_tangent.{part}" for part in ("claims", "experiments", "figures"))),
    summary=(
        "A performance network corrects the rules of a fuzzy network while a blade cuts. It learns, and beats fixed "
        "rules; tuned alike, it equals three gains in its equation (3) without rules, and a PID comes close. "
        "Feed-forward of the curvature, and learning from piece to piece, are twice as good."
    ),
    record=("actual.deviation", "actual.angle", "actual.lateral", "controller.watch", "controller.updates"),
    card=("change_by_learning", "steady_deviation_compensated", "less_after_a_change.wave"),
    assumed=ASSUMED,
    method=(
        "The cut is simulated with a period of 10 ms; lags are exact between samples. Every controller meets the same "
        "five textures and noises in each of nine cells, three lines in three materials.",
        "Laws that are compared as tuned (tuned.*) have had the same search, in drawn materials and on two lines; they "
        "are judged in other materials, with other textures and noises, on three lines.",
        "Printed columns have levels that are whole numbers, as the paper quantifies its ranges into 13 levels. "
        "Corrected columns have levels between them, a performance network that passes a safety test, and (3) as the "
        "target of the Kalman filter.",
    ),
    limits=(
        "The process is a reconstruction: nothing here is evidence about real fabric, leather or foam, nor about the "
        "authors' simulation.",
        "The camera has no zero error. One of 0.1° turns the whole cut, 0.8 mm in 450 mm, and no learning sees it.",
        "Trainings, tunings and scans that take minutes are kept in data files; slow tests make parts of them again.",
    ),
)
