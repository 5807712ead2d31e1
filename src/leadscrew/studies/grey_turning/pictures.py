"""All pictures of the study, in the order of the claims' topics."""

from __future__ import annotations

from leadscrew.studies.grey_turning.figures_ablation import ablation_pictures
from leadscrew.studies.grey_turning.figures_beyond import beyond_pictures
from leadscrew.studies.grey_turning.figures_falling import falling_pictures
from leadscrew.studies.grey_turning.figures_fixed import fixed_pictures
from leadscrew.studies.grey_turning.figures_force_law import force_law_pictures
from leadscrew.studies.grey_turning.figures_fuzzy import fuzzy_pictures
from leadscrew.studies.grey_turning.figures_grey import grey_pictures
from leadscrew.studies.grey_turning.figures_guard import guard_pictures
from leadscrew.studies.grey_turning.figures_lathe import lathe_pictures
from leadscrew.studies.grey_turning.figures_montecarlo import montecarlo_pictures
from leadscrew.studies.grey_turning.figures_process import process_pictures
from leadscrew.studies.grey_turning.figures_removal import removal_pictures
from leadscrew.studies.grey_turning.figures_rough import rough_pictures
from leadscrew.studies.grey_turning.results import Results
from leadscrew.studies.study import Picture


def all_pictures(found: Results) -> list[Picture]:
    """The paper's figures redrawn, then what lies beyond it."""
    loops, again = found.loops, found.reproduction
    return [
        *grey_pictures(loops),
        *fuzzy_pictures(loops),
        *force_law_pictures(found.entered),
        *process_pictures(loops, again),
        *fixed_pictures(loops, again),
        *falling_pictures(loops, again),
        *rough_pictures(loops, again),
        *lathe_pictures(found.lathe),
        *removal_pictures(found.removal),
        *montecarlo_pictures(loops),
        *ablation_pictures(loops),
        *beyond_pictures(loops),
        *guard_pictures(loops),
    ]
