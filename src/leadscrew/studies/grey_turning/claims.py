"""All claims of the study, topic by topic, in the order in which the report tells its story."""

from __future__ import annotations

from collections.abc import Callable

from leadscrew.report.claim import Claim
from leadscrew.studies.grey_turning.claims_ablation import ablation_claims
from leadscrew.studies.grey_turning.claims_beyond import beyond_claims
from leadscrew.studies.grey_turning.claims_errata import errata_claims
from leadscrew.studies.grey_turning.claims_falling import falling_claims
from leadscrew.studies.grey_turning.claims_fixed import fixed_claims
from leadscrew.studies.grey_turning.claims_force_law import force_law_claims
from leadscrew.studies.grey_turning.claims_fuzzy import fuzzy_claims
from leadscrew.studies.grey_turning.claims_grey import grey_claims
from leadscrew.studies.grey_turning.claims_guard import guard_claims
from leadscrew.studies.grey_turning.claims_lathe import lathe_claims
from leadscrew.studies.grey_turning.claims_montecarlo import montecarlo_claims
from leadscrew.studies.grey_turning.claims_plant import plant_claims
from leadscrew.studies.grey_turning.claims_removal import removal_claims
from leadscrew.studies.grey_turning.claims_rough import rough_claims
from leadscrew.studies.grey_turning.claims_scenarios import scenarios_claims
from leadscrew.studies.grey_turning.results import Results

Topics = list[tuple[str, list[Claim]]]


def topics(found: Results, progress: Callable[[str, float], None]) -> Topics:
    """Every claim, judged, below its heading."""
    loops = found.loops
    asked: list[tuple[str, Callable[[], list[Claim]]]] = [
        ("The grey model", lambda: grey_claims(loops)),
        ("The fuzzy controllers", lambda: fuzzy_claims(loops)),
        ("The cutting force", lambda: force_law_claims(loops, found.entered)),
        ("The lathe against its digest", lambda: plant_claims(loops, found.reproduction)),
        ("Fixed depth of cut: Figures 6 and 7", lambda: fixed_claims(loops, found.reproduction)),
        ("Falling depth of cut: Figures 9 and 10", lambda: falling_claims(loops, found.reproduction)),
        ("Rules and factors roughly chosen: Figure 11", lambda: rough_claims(loops, found.reproduction)),
        ("What the paper has wrong", lambda: errata_claims(loops, found.reproduction)),
        ("Every scenario", lambda: scenarios_claims(loops)),
        ("The three loops together", lambda: lathe_claims(found.lathe)),
        ("Metal removed", lambda: removal_claims(found.removal)),
        ("Random plants", lambda: montecarlo_claims(loops)),
        ("The predictor at equal tuning effort", lambda: ablation_claims(loops)),
        ("Beyond the paper", lambda: beyond_claims(loops)),
        ("Protection", lambda: guard_claims(loops)),
    ]
    judged: Topics = []
    for number, (title, claims) in enumerate(asked):
        progress(title, number / len(asked))
        judged.append((title, claims()))
    return judged
