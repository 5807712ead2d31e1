"""Property tests of the door: whatever text comes in, one line goes out that names the key."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.cli.values import parse
from leadscrew.experiment import Experiment
from leadscrew.kernel.parameters import ParameterSpec
from leadscrew.util.errors import LeadscrewError
from tests.cli.conftest import FILE

STUDY = f"{FILE}:STUDY"
KEYS = ("plant.lag_s", "controller.stages", "controller.inverted", "controller.table", "scenario.target_mm")
SHEET = Experiment(STUDY, "p", "small").settable()
WHOLE = ParameterSpec("controller.stages", "int", 1, "", "")
NUMBERISH = st.text(alphabet="0123456789+-.eE_naifINF[], truefalsTRUE\n\x00\t١²", max_size=40)
TEXTS = st.one_of(st.text(max_size=60), NUMBERISH, st.floats().map(str), st.integers().map(str))


@settings(max_examples=200, deadline=None)
@given(st.sampled_from(KEYS), TEXTS)
def test_a_value_is_read_or_refused_by_name(key, text):
    try:
        found = parse([f"{key}={text}"], SHEET)
    except LeadscrewError as error:
        assert key in str(error)
    else:
        assert list(found) == [key]
        SHEET[key].check(found[key])


def test_a_whole_number_that_a_double_cannot_hold_is_refused():
    assert parse([f"controller.stages={2**53}"], {"controller.stages": WHOLE}) == {"controller.stages": 2**53}
    for text in (f"{2**53 + 1}", f"-{2**53 + 1}", "1e16", "2.5", "inf"):
        with pytest.raises(LeadscrewError, match=r"controller\.stages = .*expected a whole number"):
            parse([f"controller.stages={text}"], {"controller.stages": WHOLE})


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.one_of(st.text(max_size=40), st.tuples(st.sampled_from(KEYS), TEXTS).map("=".join)))
def test_the_command_line_never_shows_a_traceback(text):
    result = CliRunner().invoke(
        app, ["simulate", STUDY, "-c", "p", "-s", "small", "--duration", "0.002", "--set", text]
    )
    assert result.exit_code in (0, 2, 3), (result.exit_code, result.output, result.exception)
    if result.exit_code == 2:
        assert result.stdout == "" and result.stderr.count("\n") == 1
        key = text.partition("=")[0].strip()
        assert not key.isprintable() or not key.isascii() or "\\" in key or "'" in key or key in result.stderr


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(st.text(max_size=40))
def test_any_name_of_a_study_is_refused_in_one_line(name):
    result = CliRunner().invoke(app, ["list", "--", name])
    assert result.exit_code in (0, 2), (name, result.exit_code, result.output)
    if result.exit_code == 2:
        assert result.stderr.count("\n") == 1
