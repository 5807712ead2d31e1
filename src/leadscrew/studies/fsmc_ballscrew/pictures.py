"""All pictures of the study, in the order of its story."""

from __future__ import annotations

from leadscrew.studies.fsmc_ballscrew.figures_backlash import backlash_pictures
from leadscrew.studies.fsmc_ballscrew.figures_beaten import beaten_pictures
from leadscrew.studies.fsmc_ballscrew.figures_circle import circle_pictures
from leadscrew.studies.fsmc_ballscrew.figures_friction import friction_pictures
from leadscrew.studies.fsmc_ballscrew.figures_fuzzy import fuzzy_pictures
from leadscrew.studies.fsmc_ballscrew.figures_integrators import integrator_pictures
from leadscrew.studies.fsmc_ballscrew.figures_learning import learning_pictures
from leadscrew.studies.fsmc_ballscrew.figures_sampled import sampled_pictures
from leadscrew.studies.fsmc_ballscrew.figures_selftuned import selftuned_pictures
from leadscrew.studies.fsmc_ballscrew.figures_tracking import tracking_pictures
from leadscrew.studies.fsmc_ballscrew.results import Results
from leadscrew.studies.study import Picture


def all_pictures(found: Results) -> list[Picture]:
    """Friction and backlash, tracking, the ball bar."""
    loops = found.loops
    return [
        *friction_pictures(loops),
        *tracking_pictures(loops),
        *fuzzy_pictures(loops),
        *sampled_pictures(loops),
        *selftuned_pictures(loops, found.fits),
        *beaten_pictures(loops, found.learned),
        *learning_pictures(loops),
        *backlash_pictures(loops),
        *circle_pictures(loops, found.circles),
        *integrator_pictures(loops),
    ]
