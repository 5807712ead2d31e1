"""All pictures of the study, in the order of the claims' topics."""

from __future__ import annotations

from leadscrew.studies.npid_xytable.figures_certified import certified_pictures
from leadscrew.studies.npid_xytable.figures_chatter import chatter_pictures
from leadscrew.studies.npid_xytable.figures_comparison import comparison_pictures
from leadscrew.studies.npid_xytable.figures_design import design_pictures
from leadscrew.studies.npid_xytable.figures_friction import friction_pictures
from leadscrew.studies.npid_xytable.figures_harmonics import harmonics_pictures
from leadscrew.studies.npid_xytable.figures_law import law_pictures
from leadscrew.studies.npid_xytable.figures_rejection import rejection_pictures
from leadscrew.studies.npid_xytable.figures_spindle import spindle_pictures
from leadscrew.studies.npid_xytable.figures_stability import stability_pictures
from leadscrew.studies.npid_xytable.figures_table2 import table2_pictures
from leadscrew.studies.npid_xytable.figures_two_mass import two_mass_pictures
from leadscrew.studies.npid_xytable.results import Results
from leadscrew.studies.study import Picture


def all_pictures(found: Results) -> list[Picture]:
    """The law, Table II, stability, controllers, plants."""
    loops = found.loops
    return [
        *law_pictures(loops),
        *table2_pictures(),
        *harmonics_pictures(loops),
        *stability_pictures(),
        *chatter_pictures(loops),
        *design_pictures(loops),
        *rejection_pictures(loops),
        *certified_pictures(loops),
        *comparison_pictures(found),
        *two_mass_pictures(found.two_mass),
        *friction_pictures(found.friction),
        *spindle_pictures(found.spindle),
    ]
