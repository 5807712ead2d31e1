"""Friction of the tribometer records of FrictionModels.jl, judged on data that no fit has seen; skipped without."""

from __future__ import annotations

import numpy as np
import pytest

from leadscrew.identify.friction_force import identify_friction_force, read_force_record
from leadscrew.identify.friction_force.result import LUGRE, MAP, SLIP, better_percent
from tests.fuzzy.formats_systems import shared

FOLDER = "data/friction_tribometer"
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def tribometer():
    return identify_friction_force(read_force_record(shared(f"{FOLDER}/test_data_2.txt")))


def test_the_record_is_read_as_it_is(tribometer):
    r = tribometer.record
    raw = np.loadtxt(shared(f"{FOLDER}/test_data_2.txt"), skiprows=1)
    assert len(r.time) == 42579 and tribometer.training == 21290
    assert r.turned and r.force == pytest.approx(-1e-6 * raw[:, 3])
    assert r.position == pytest.approx(1e-3 * (raw[:, 2] - raw[0, 2]), abs=1e-12)
    assert r.encoder_step == pytest.approx(1e-7, rel=1e-6)
    assert any("179 steps of time" in f.sentence for f in r.findings)


def test_lugre_leaves_a_tenth_of_the_amplitude_on_the_second_half(tribometer):
    second = tribometer.record.force[21290:]
    assert tribometer.amplitude == pytest.approx(0.5 * np.ptp(second))
    assert tribometer.chosen.holdout_percent < 12.0
    assert better_percent(tribometer.models, LUGRE) >= 30.0
    assert better_percent(tribometer.others, LUGRE) >= 30.0
    assert better_percent(tribometer.models, SLIP) > better_percent(tribometer.models, LUGRE)


def test_the_yardstick_is_the_best_that_coulomb_and_viscous_friction_can_do(tribometer):
    """Least squares again, by hand, on the raw columns."""
    r, n = tribometer.record, tribometer.training
    for models, weight in ((tribometer.models, r.normal), (tribometer.others, np.ones(len(r.time)))):
        columns = np.column_stack([r.way == 1.0, -1.0 * (r.way == -1.0), r.speed]) * weight[:, None]
        best = np.linalg.lstsq(columns[:n], r.force[:n], rcond=None)[0]
        left = r.force[n:] - columns[n:] @ best
        assert models[MAP].holdout_rms == pytest.approx(np.sqrt(np.mean(left**2)))


def test_no_speed_of_the_tribometer_tells_viscous_friction(tribometer):
    viscous = tribometer.chosen.parameters["friction.forward.viscous"]
    assert viscous.how == "fixed" and viscous.value == 0.0 and "factor of 1.3" in viscous.note


def test_the_simulated_record_was_made_by_the_values_that_are_found():
    """test_data_1.csv is no measurement: v = 1.5 sin(10 pi t) at 100 N, and LuGre with round numbers."""
    record = read_force_record(shared(f"{FOLDER}/test_data_1.csv"))
    assert record.speed == pytest.approx(1.5 * np.sin(10.0 * np.pi * record.time), abs=3e-5)
    fit = identify_friction_force(record)
    found = fit.chosen.parameters
    assert found["friction.forward.coulomb"].value == pytest.approx(0.15, rel=0.01)
    assert found["friction.forward.static"].value == pytest.approx(0.25, rel=0.02)
    assert found["friction.forward.stribeck_speed"].value == pytest.approx(0.25, rel=0.02)
    assert any("rest on little" in note for note in fit.notes)


def test_coulomb_alone_is_within_the_interval_that_the_published_tool_gives():
    """Its README fits these 433 rows with Coulomb friction only: 0.147525, 95 % from 0.140794 to 0.154256."""
    r = read_force_record(shared(f"{FOLDER}/test_data_1.csv"))
    column = np.sign(r.speed) * r.normal
    assert 0.140794 < float(column @ r.force / (column @ column)) < 0.154256
