"""All claims of the study, topic by topic, in the order in which the report tells its story."""

from __future__ import annotations

from collections.abc import Callable

from leadscrew.report.claim import Claim
from leadscrew.studies.fsmc_ballscrew.claims_attraction import attraction_claims
from leadscrew.studies.fsmc_ballscrew.claims_backlash import backlash_claims
from leadscrew.studies.fsmc_ballscrew.claims_beaten import beaten_claims
from leadscrew.studies.fsmc_ballscrew.claims_circle import circle_claims
from leadscrew.studies.fsmc_ballscrew.claims_circle_analytic import circle_analytic_claims
from leadscrew.studies.fsmc_ballscrew.claims_continuous import continuous_claims
from leadscrew.studies.fsmc_ballscrew.claims_creep import creep_claims
from leadscrew.studies.fsmc_ballscrew.claims_drive import drive_claims
from leadscrew.studies.fsmc_ballscrew.claims_errata import errata_claims
from leadscrew.studies.fsmc_ballscrew.claims_friction import friction_claims
from leadscrew.studies.fsmc_ballscrew.claims_fuzzy import fuzzy_claims
from leadscrew.studies.fsmc_ballscrew.claims_integrators import integrator_claims
from leadscrew.studies.fsmc_ballscrew.claims_learning import learning_claims
from leadscrew.studies.fsmc_ballscrew.claims_paper import paper_claims
from leadscrew.studies.fsmc_ballscrew.claims_readings import readings_claims
from leadscrew.studies.fsmc_ballscrew.claims_robust_continuous import robust_continuous_claims
from leadscrew.studies.fsmc_ballscrew.claims_sampled import sampled_claims
from leadscrew.studies.fsmc_ballscrew.claims_selftuned import selftuned_claims
from leadscrew.studies.fsmc_ballscrew.results import Results

Topics = list[tuple[str, list[Claim]]]


def topics(found: Results, progress: Callable[[str, float], None]) -> Topics:
    """Every claim, judged, below its heading."""
    loops = found.loops
    asked: list[tuple[str, Callable[[], list[Claim]]]] = [
        ("Friction", lambda: friction_claims(loops)),
        ("What the paper says of its controllers", lambda: paper_claims(loops)),
        ("Without sampling: errors and torques", lambda: continuous_claims(loops)),
        ("Readings of the equations", lambda: readings_claims(loops)),
        ("The fuzzy system", lambda: fuzzy_claims(loops)),
        ("Wrong friction, wrong inertia, and sampling the printed gains", lambda: robust_continuous_claims(loops)),
        ("Errata", lambda: errata_claims(loops)),
        ("Where the fuzzy law attracts", lambda: attraction_claims(loops)),
        ("Sampled at 4 kHz", lambda: sampled_claims(loops)),
        ("A real drive", lambda: drive_claims(loops)),
        ("Friction identified from one record", lambda: selftuned_claims(loops, found.fits)),
        ("Friction learned on the way", lambda: beaten_claims(loops, found.learned)),
        ("Learned from pass to pass", lambda: learning_claims(loops)),
        ("Backlash", lambda: backlash_claims(loops)),
        ("The ball bar's quantities", circle_analytic_claims),
        ("Circles", lambda: circle_claims(loops, found.circles)),
        ("Creeping feeds", lambda: creep_claims(loops)),
        ("Integration", lambda: integrator_claims(loops)),
    ]
    judged: Topics = []
    for number, (title, claims) in enumerate(asked):
        progress(title, number / len(asked))
        judged.append((title, claims()))
    return judged
