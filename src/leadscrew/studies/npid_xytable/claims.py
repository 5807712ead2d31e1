"""All claims of the study, topic by topic, in the order in which the report tells its story."""

from __future__ import annotations

from collections.abc import Callable

from leadscrew.report.claim import Claim
from leadscrew.studies.npid_xytable.claims_box import box_claims
from leadscrew.studies.npid_xytable.claims_certificates import certificates_claims
from leadscrew.studies.npid_xytable.claims_certified import certified_claims
from leadscrew.studies.npid_xytable.claims_chatter import chatter_claims
from leadscrew.studies.npid_xytable.claims_columns import columns_claims
from leadscrew.studies.npid_xytable.claims_comparison import comparison_claims
from leadscrew.studies.npid_xytable.claims_design import design_claims
from leadscrew.studies.npid_xytable.claims_friction import friction_claims
from leadscrew.studies.npid_xytable.claims_harmonics import harmonics_claims
from leadscrew.studies.npid_xytable.claims_law import law_claims
from leadscrew.studies.npid_xytable.claims_rejection import rejection_claims
from leadscrew.studies.npid_xytable.claims_spindle import spindle_claims
from leadscrew.studies.npid_xytable.claims_stability import stability_claims
from leadscrew.studies.npid_xytable.claims_table2 import table2_claims
from leadscrew.studies.npid_xytable.claims_two_mass import two_mass_claims
from leadscrew.studies.npid_xytable.claims_variants import variants_claims
from leadscrew.studies.npid_xytable.results import Results

Topics = list[tuple[str, list[Claim]]]


def topics(found: Results, progress: Callable[[str, float], None]) -> Topics:
    """Every claim, judged, below its heading."""
    loops, trials = found.loops, found.trials
    asked: list[tuple[str, Callable[[], list[Claim]]]] = [
        ("The law", lambda: law_claims(loops)),
        ("Table II as printed", lambda: table2_claims(loops)),
        ("Amplitudes of lines, measured", lambda: harmonics_claims(loops)),
        ("Table II from simulation", lambda: columns_claims(loops)),
        ("Where the loop is stable", lambda: stability_claims(loops)),
        ("What is proved", lambda: certificates_claims(loops)),
        ("Chatter", lambda: chatter_claims(loops)),
        ("Design", lambda: design_claims(loops)),
        ("Other laws of the same kind, and what the paper recommends", lambda: variants_claims(loops)),
        ("Integral action, observers, resonators", lambda: rejection_claims(loops)),
        ("A certified nonlinear law against the best linear one", lambda: certified_claims(loops)),
        ("All controllers on the same cuts", lambda: comparison_claims(trials)),
        ("Plants off the nominal one", lambda: box_claims(trials)),
        ("A mode of the screw", lambda: two_mass_claims(loops, found.two_mass)),
        ("Friction", lambda: friction_claims(loops, found.friction)),
        ("Other spindle speeds", lambda: spindle_claims(loops, found.spindle)),
    ]
    judged: Topics = []
    for number, (title, claims) in enumerate(asked):
        progress(title, number / len(asked))
        judged.append((title, claims()))
    return judged
