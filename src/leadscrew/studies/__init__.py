"""Studies of published systems: ``from leadscrew.studies import Study, claim, measure`` and what else a study takes."""

from typing import TYPE_CHECKING

from leadscrew.lazy import doors

if TYPE_CHECKING:
    from leadscrew.figures.table import Table as Table
    from leadscrew.studies.claims import Measured as Measured
    from leadscrew.studies.claims import at_least as at_least
    from leadscrew.studies.claims import at_most as at_most
    from leadscrew.studies.claims import claim as claim
    from leadscrew.studies.claims import equals as equals
    from leadscrew.studies.claims import within as within
    from leadscrew.studies.exhibits import experiment as experiment
    from leadscrew.studies.exhibits import figure as figure
    from leadscrew.studies.lab import Lab as Lab
    from leadscrew.studies.lab import measure as measure
    from leadscrew.studies.results import contents_of as contents_of
    from leadscrew.studies.results import evaluate as evaluate
    from leadscrew.studies.study import Assumption as Assumption
    from leadscrew.studies.study import Scenario as Scenario
    from leadscrew.studies.study import Study as Study

__getattr__, __dir__ = doors(
    globals(),
    {
        "claims": "Measured at_least at_most claim equals within",
        "exhibits": "Table experiment figure",
        "lab": "Lab measure",
        "results": "contents_of evaluate",
        "study": "Assumption Scenario Study",
    },
)
