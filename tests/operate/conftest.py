"""Machines of the bench for the tests of this folder."""

import pytest

from leadscrew.operate.operated import Operated, Start
from tests.operate.bench_study import NAME


@pytest.fixture(scope="module")
def machines():
    """Machines of the bench by controller, built once; each test takes fresh ones."""
    return {c: Operated(Start(NAME, c, "way")) for c in ("pid", "gain", "mean")}


@pytest.fixture
def machine(machines):
    """Gives a fresh machine by its controller."""
    return lambda controller="pid": machines[controller].restarted()
