"""Whole evaluations, each made once: its tests and those of the pages that quote it run in one process.

``pytest --dist loadgroup`` keeps tests with one ``xdist_group`` together; without it each worker evaluates for itself.
Where ``LEADSCREW_STUDY_PAGES`` is ``keep``, as in CI, the page of the documentation is written of the same evaluation.
"""

import runpy
from functools import cache
from pathlib import Path

import pytest

from leadscrew import catalogue
from leadscrew.report.claim import Claim
from leadscrew.studies.study import StudyResult
from tests.studies.contract import plain

DOCS = Path(__file__).parents[2] / "docs"


@cache
def whole(name: str) -> StudyResult:
    """The result of a study; its progress only goes up, and ends at 1."""
    said: list[float] = []
    result = catalogue.study(name).evaluate(lambda what, done: said.append(done))
    assert sorted(said) == said and said[-1] == 1.0
    writer = runpy.run_path(str(DOCS / "generate.py"))
    if writer["kept"]():
        writer["write_study"](DOCS, catalogue.study(name), result)
    return result


def claims_of(name: str) -> dict[str, Claim]:
    """Its claims by their names without the study's."""
    return plain(catalogue.study(name), whole(name).claims)


def together(name: str) -> list[pytest.MarkDecorator]:
    """Marks of a test that needs a whole evaluation."""
    return [pytest.mark.slow, pytest.mark.xdist_group(f"whole {name}")]
