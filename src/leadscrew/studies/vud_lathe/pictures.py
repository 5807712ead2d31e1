"""All pictures of the study, in the order of its story."""

from __future__ import annotations

from leadscrew.controllers.vud.universe import contraction
from leadscrew.studies.study import Picture
from leadscrew.studies.vud_lathe.figures import pictures
from leadscrew.studies.vud_lathe.figures_accuracy import accuracy_pictures
from leadscrew.studies.vud_lathe.figures_contraction import contraction_pictures
from leadscrew.studies.vud_lathe.figures_differentiator import differentiator_pictures
from leadscrew.studies.vud_lathe.figures_limits import limits_pictures
from leadscrew.studies.vud_lathe.figures_original import original_pictures
from leadscrew.studies.vud_lathe.figures_positioning import positioning_pictures
from leadscrew.studies.vud_lathe.figures_sensor import sensor_pictures
from leadscrew.studies.vud_lathe.results import Results
from leadscrew.studies.vud_lathe.rules import SETS
from leadscrew.studies.vud_lathe.runs import STEPS


def all_pictures(found: Results) -> list[Picture]:
    """Moves, universes, the old servo, sensors, limits, positioning."""
    example = SETS.contracted(contraction(-0.25, 0.9, 1e-4, 1.0)), SETS.contracted(contraction(0.12, 0.9, 1e-4, 1.0))
    shown = "corrected.vud_beta_e"
    return [
        *pictures(found.runs, found.moves, example),
        *contraction_pictures(found.runs[f"{STEPS[0]}/{shown}"], shown),
        *original_pictures(found.original, found.moves),
        *differentiator_pictures(found.loops),
        *sensor_pictures(),
        *accuracy_pictures(found.errors),
        *limits_pictures(found.loops),
        *positioning_pictures(found.positioning),
    ]
