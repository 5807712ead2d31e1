"""What is odd about a friction log is said, what is no friction is refused: units, swapped columns, a drive's force."""

from __future__ import annotations

import numpy as np
import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.identify.friction_force import force_record, identify_friction_force, read_force_record
from leadscrew.identify.friction_force.checks import doubles
from leadscrew.kernel.errors import DataError, ValueRefused
from tests.identify import hostile
from tests.identify.friction_force_logs import log


def moved(amplitude=0.05, period=1e-3, mass=0.0):
    """Strokes of some speeds with Coulomb and viscous friction and the force of a mass; sines and their derivatives."""
    t = np.arange(6000) * period
    w, a = np.array([1.0, 2.7, 5.3]), amplitude * np.array([1.0, 0.4, 0.12])
    phase = np.outer(t, w)
    x = (a * (1.0 - np.cos(phase))).sum(axis=1)
    v, acceleration = (a * w * np.sin(phase)).sum(axis=1), (a * w * w * np.cos(phase)).sum(axis=1)
    return t, 15.0 * np.sign(v) + 20.0 * v + mass * acceleration, x


def said(t, force, x, **more):
    return {f.kind: f.sentence for f in force_record(t, force, position=x, **more).findings}


def test_an_honest_log_is_found_fault_with_by_no_check():
    assert said(*moved()) == {}


def test_positions_in_mm_taken_as_m_are_said_with_the_option_that_mends_it():
    t, force, x = moved()
    found = said(t, force, 1000.0 * x)
    top = np.abs(np.diff(1000.0 * x) / 1e-3).max()
    assert top > 100.0 and "more than 20 m/s" in found["unit"] and "--unit position=mm" in found["unit"]


def test_times_in_ms_taken_as_s_are_said_with_the_option_that_mends_it():
    t, force, x = moved()
    assert "a period of 1 s" in said(1000.0 * t, force, x)["unit"]
    assert "--unit time=ms" in said(1000.0 * t, force, x)["unit"]


def test_swapped_columns_are_refused_by_their_look():
    t, force, x = moved(mass=40.0)
    with pytest.raises(DataError, match="the two columns are swapped; name them with --force NAME --position NAME"):
        force_record(t, x, position=force)


@pytest.mark.parametrize(("mass", "there"), [(0.0, False), (5.0, False), (100.0, True)])
def test_the_force_of_a_drive_is_known_by_the_mass_in_it(mass, there):
    found = said(*moved(mass=mass))
    assert ("mass" in found) is there
    if there:
        assert "that of 100 kg speeding up" in found["mass"] and "identify axis" in found["mass"]


def test_a_force_in_which_nothing_slides_is_refused_and_not_fitted():
    # Nothing but inertia, turned so that it takes energy out: no spring of Maxwell slip has a share in it.
    t, _, x = moved()
    v = np.gradient(x, t)
    force = 1e3 * np.gradient(v, t) + 300.0 * v
    with pytest.raises(DataError, match=r"arrays: (no part of the force|while it slides)"):
        identify_friction_force(force_record(t, force, position=x))


@pytest.mark.slow
def test_one_direction_without_friction_is_fitted_from_inside_its_bounds():
    t, x, _ = log(repeats=2)
    ahead = np.gradient(x, t) > 0.0
    rng = np.random.default_rng(1)
    force = np.where(ahead, 3.0, 0.05) + 0.01 * rng.standard_normal(len(t))
    fit = identify_friction_force(force_record(t, force, position=x), holdout=0.3)
    level = fit.models["Stribeck map"].friction.forward.coulomb
    assert level == pytest.approx(3.0, rel=0.1)


def test_a_time_that_falls_is_said_to_fall(tmp_path):
    path = hostile.write(tmp_path, "a time that falls")
    with pytest.raises(DataError, match=r"the time falls from 5\.999 to 0 s in every row"):
        read_force_record(path)


def test_of_two_columns_of_one_name_the_one_that_was_taken_is_named(tmp_path):
    found = read_force_record(hostile.write(tmp_path, "two columns of one name")).findings
    assert any("a second 'position_m'" in f.sentence and "'position_m' was taken" in f.sentence for f in found)
    assert doubles(["column 4 is a second 'a': called 'a (2)'"], ["b"]) == []


def test_columns_are_named_as_in_other_commands_and_a_period_stands_for_a_column_of_times(tmp_path):
    t, force, x = moved()
    path = tmp_path / "log.csv"
    np.savetxt(path, np.column_stack([force, x]), delimiter=",", header="Fx,x", comments="")
    with pytest.raises(DataError, match=r"no column is the time .* --period SECONDS"):
        read_force_record(path, columns={"force": "Fx"})
    found = read_force_record(path, columns={"force": "Fx"}, period=1e-3, end=2.0)
    assert found.time == pytest.approx(t[:2001]) and found.force == pytest.approx(force[:2001])
    with pytest.raises(ValueRefused, match="give one of them"):
        read_force_record(path, columns={"force": "Fx", "time": "x"}, period=1e-3)
    with pytest.raises(ValueRefused, match="period = 0"):
        read_force_record(path, columns={"force": "Fx"}, period=0.0)
    done = CliRunner().invoke(
        app, ["identify", "friction-force", str(path), "--column", "force=Fx", "--force", "x", "--period", "0.001"]
    )
    assert done.exit_code == 2 and "name one column" in done.stderr
