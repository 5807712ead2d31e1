"""What is odd about a friction log is said, what is no friction is refused: units, swapped columns, a drive's force."""

from __future__ import annotations

import numpy as np
import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.identify.friction_force import force_record, identify_friction_force, read_force_record
from leadscrew.identify.friction_force.record import doubles, encoder_step, slopes, without_flicker
from leadscrew.util.errors import DataError, ValueRefused
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


UM = 1e-6
EVERY = 1e-3


@pytest.mark.parametrize(
    ("counts_a_sample", "step"),
    [
        (0.4, UM),  # rests after every move but every other one
        (0.8, UM),  # a quarter of the moves is followed by a rest
        (0.95, 0.0),  # one in nineteen: a constant speed with a stop now and then
        (1.0, 0.0),  # every sample the same step: a constant speed
        (1.5, UM),  # ones and twos
    ],
)
def test_a_slow_axis_shows_its_count_and_a_constant_speed_none(counts_a_sample, step):
    x = UM * np.floor(counts_a_sample * np.arange(400) + 1e-9)
    assert encoder_step(x) == pytest.approx(step)


def test_a_count_is_known_from_ten_moves_on_and_where_99_in_100_differences_are_multiples():
    assert encoder_step(UM * np.repeat(np.arange(11), 3)) == pytest.approx(UM)
    assert encoder_step(UM * np.repeat(np.arange(10), 3)) == 0.0
    moves = np.tile([1.0, 0.0, 2.0, -1.0], 500)  # 1,500 of 2,000 move
    for spoiled, step in ((14, UM), (16, 0.0)):
        odd = moves.copy()
        odd[2 : 2 + 4 * spoiled : 4] = 2.5
        assert encoder_step(UM * np.cumsum(odd)) == pytest.approx(step), spoiled
    for off, step in ((0.04, UM), (0.06, 0.0)):
        odd = moves.copy()
        odd[2::4] += off
        assert encoder_step(UM * np.cumsum(odd)) == pytest.approx(step), off


def test_two_counts_back_are_flicker_and_three_a_reversal():
    forth = [0.0, 1.0, 4.0, 3.0, 2.0, 5.0, 6.0, 4.0, 3.0, 2.0, 4.0, 1.0]
    held = [0.0, 0.0, 4.0, 4.0, 4.0, 5.0, 6.0, 6.0, 3.0, 2.0, 2.0, 1.0]
    assert without_flicker(UM * np.array(forth), UM) == pytest.approx(UM * np.array(held))
    assert without_flicker(UM * np.array(forth), 0.0) == pytest.approx(UM * np.array(forth))


@pytest.mark.parametrize(
    ("speed", "half"),
    [(1.0, 1), (0.0125, 2), (0.005, 5), (0.001, 25), (1e-4, 25)],  # m/s at a count of 1 um each ms: 1/(20 v) samples
)
def test_the_speed_is_taken_over_as_many_samples_as_make_a_count_a_fiftieth_of_it(speed, half):
    """A kink of the position: its slope is smeared over just as many samples to each side."""
    t = EVERY * np.arange(301)
    x = speed * np.abs(t - t[150])
    found = slopes(t, x, UM)
    expected = speed * np.clip(np.arange(-150, 151) / half, -1.0, 1.0)
    assert found[half:-half] == pytest.approx(expected[half:-half], rel=1e-9, abs=1e-9)


def test_a_force_that_takes_a_twentieth_of_its_size_as_work_is_friction_and_one_that_takes_less_is_refused():
    t = 1e-3 * np.arange(1001)
    x = 0.01 * (1.0 - np.cos(4.0 * np.pi * t))
    along = np.sign(np.sin(4.0 * np.pi * t))
    # elastic: as much is given back as is taken, +-1 N; and friction of f N on top, so the share is f / 1
    spring = np.sign(x - 0.01)
    for f, turned in ((0.055, False), (-0.055, True)):
        assert force_record(t, spring + f * along, position=x).turned is turned
    for f in (0.045, -0.045):
        with pytest.raises(DataError, match=r"the force does no work on the motion \(sum of F dx is -?4\.5 %"):
            force_record(t, spring + f * along, position=x)
    assert not force_record(t, spring + 0.045 * along, position=x, sign=1).turned
