"""A system written to a file and read back is the same system, in every format that can say it."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from leadscrew.fuzzy import formats
from leadscrew.fuzzy.rules_text import parse, rule_text
from tests.budget import WHOLE
from tests.fuzzy.formats_systems import systems

MANY = settings(max_examples=100 if WHOLE else 5, deadline=None, suppress_health_check=list(HealthCheck))


@pytest.mark.parametrize("format", formats.WRITTEN)
@given(st.data())
@MANY
def test_a_system_survives_its_file(format, data):
    system = data.draw(systems(format))
    text = formats.dumps(system, format)
    found = formats.loads(text, format)
    assert found == system
    assert formats.dumps(found, format) == text


@pytest.mark.slow
@given(st.data())
@MANY
def test_a_rule_survives_its_text(data):
    for format in ("fis", "fll"):
        system = data.draw(systems(format))
        for rule in system.rules:
            assert parse(rule_text(rule), system) == rule


@pytest.mark.slow
@given(st.data())
@settings(max_examples=50, deadline=None, suppress_health_check=list(HealthCheck))
def test_a_matlab_system_survives_fuzzylites_formats(data):
    """Names with spaces are renamed, and nothing else changes."""
    system = data.draw(systems("fis"))
    for format in ("fll", "fcl"):
        notes: list[str] = []
        found = formats.loads(formats.dumps(system, format, notes), format)
        again = formats.loads(formats.dumps(found, format), format)
        assert again == found
        if not any("is called" in note for note in notes):
            assert (found.inputs, found.outputs) == (system.inputs, system.outputs)
            assert found.rules == system.rules
