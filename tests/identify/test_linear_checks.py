"""What is said or refused of the signals of a linear fit, what is told of it, and which machine it makes."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from leadscrew.identify.linear.choose import Task, _score, choose, late
from leadscrew.identify.linear.fit import identify_linear
from leadscrew.identify.linear.model import Structure
from leadscrew.identify.linear.record import linear_record, read_linear
from leadscrew.identify.linear.result import Parameter, block, machine, machine_values
from leadscrew.identify.linear.uncertainty import Quantities, _poles, within
from leadscrew.report.identified_linear import parameter_table, stretch_table
from leadscrew.util.errors import DataError
from tests.identify.test_linear import T, axis, finer, levels

MM_PER_M = 1e3


def move(samples=1500, scale=1.0):
    """An axis of 40 kg and 120 N s/m under levels of force; force in N, position in m times ``scale``."""
    rng = np.random.default_rng(7)
    force = 60.0 * levels(rng, samples)
    position = finer([1.0 / 40.0], [1.0, 3.0, 0.0], force, 1e-3) + 1e-6 * rng.standard_normal(samples)
    return T * np.arange(samples), force, scale * np.round(position / 1e-6) * 1e-6


def record(position, **units):
    t, force, _ = move(len(position))
    return linear_record(t, force, position, **{"input_unit": "N", "output_unit": "m", **units})


def test_a_right_log_of_an_axis_is_taken_without_a_word():
    assert record(move()[2]).notes == []


def test_a_position_that_no_axis_has_is_refused_with_its_unit_and_taken_in_the_right_one():
    metres = move()[2]
    with pytest.raises(DataError, match=r"more than 20 m/s.*--unit output=mm"):
        record(3e3 * metres)
    assert record(MM_PER_M * metres, output_unit="mm").notes == []
    # What is no length may be of any size.
    assert record(3e3 * metres, output_unit="degC").notes == []


def test_a_chatter_of_one_count_is_a_standstill_and_no_model():
    with pytest.raises(DataError, match="is at rest"):
        record(0.05 + 1e-7 * (np.arange(1500) % 2))


def test_faults_that_another_system_could_have_are_said_and_not_refused():
    t, force, metres = move()
    jumped = metres + 4e-3 * (np.arange(1500) >= 700)
    assert any("jumps" in note for note in record(jumped).notes)
    few = np.where(t > 0.7, 50.0, -50.0)
    answered = linear_record(t, few, metres + 4e-5 * np.roll(few, 1), input_unit="V", output_unit="m")
    assert not any("jumps" in note for note in answered.notes)
    clipped = linear_record(t, np.clip(force + 20.0 * np.sin(9.0 * t), -40.0, 40.0), metres, input_unit="N",
                            output_unit="m")  # fmt: skip
    assert any("clipped" in note for note in clipped.notes)
    slow = linear_record(1e3 * t, force, metres, input_unit="N", output_unit="m")
    assert any("period of 1 s" in note for note in slow.notes)
    thermal = linear_record(1e3 * t, force, metres, input_unit="W", output_unit="degC")
    assert thermal.notes == []


def test_columns_are_those_that_the_log_command_tells_by_their_names(tmp_path):
    path = tmp_path / "log.csv"
    np.savetxt(path, np.column_stack(move()), delimiter=",", header="time_s,force_N,position_m", comments="")
    found = read_linear(path)
    assert (found.input_name, found.output_name, found.input_unit, found.output_unit) == ("force", "position", "N", "m")
    np.savetxt(path, np.column_stack(move()), delimiter=",", header="time_s,one,two", comments="")
    with pytest.raises(DataError, match=r"--input|--output"):
        read_linear(path)
    np.savetxt(path, np.column_stack(move()[1:]), delimiter=",", header="force_N,position_m", comments="")
    assert read_linear(path, period=2e-3).period == pytest.approx(2e-3)
    with pytest.raises(DataError, match="time"):
        read_linear(path)
    np.savetxt(path, np.column_stack(move())[::-1], delimiter=",", header="time_s,force_N,position_m", comments="")
    with pytest.raises(DataError, match="time falls"):
        read_linear(path)


@pytest.mark.slow
def test_a_machine_has_the_counts_and_the_noise_of_the_log_and_its_drive_turned_forwards():
    fit = identify_linear(record(MM_PER_M * move()[2], output_unit="mm"), structure=(2, 0, 1))
    made = machine(fit, "axis")
    assert made.resolution == pytest.approx(1e-3, rel=1e-6)
    # Third differences of a position with noise and counts; the sensor of the machine rounds by itself.
    assert made.noise == pytest.approx(1e-3, rel=0.2)
    assert "drive_turned" not in made.identified
    back = identify_linear(record(-MM_PER_M * move()[2], output_unit="mm"), structure=(2, 0, 1))
    assert any("gain is negative" in note for note in back.notes)
    turned = machine(back, "axis")
    assert turned.identified["drive_turned"] is True
    assert turned.parameters["numerator"] == pytest.approx(made.parameters["numerator"], rel=1e-6)
    assert machine_values(back)["numerator"][0] == -back.numerator[0] and back.numerator[0] < 0.0
    assert float(block(back).params.c @ np.ones(2)) < 0.0
    assert turned.identified["notes"] == back.notes


def test_of_a_model_that_explains_nothing_no_machine_is_made():
    fit = identify_linear(record(move()[2]), structure=(2, 0, 1))
    with pytest.raises(DataError, match="no model of it, and so no machine"):
        machine(replace(fit, excited_hz=(0.0, 0.0)), "axis")


def test_a_pole_beyond_what_the_input_moves_unsettles_what_depends_on_it_and_not_the_gain():
    fit = identify_linear(record(MM_PER_M * move()[2], output_unit="mm"), structure=(2, 0, 1))
    found = Quantities(fit.coefficients, fit.parameters, fit.offset, fit.covariance, fit.bode)
    pole_hz = abs(fit.parameters["pole 1"].value) / (2.0 * np.pi)
    assert all(p.identifiable for p in (*fit.parameters.values(), *fit.coefficients.values()))
    assert within(found, 0.6 * pole_hz) == found
    less = within(found, 0.4 * pole_hz)
    assert [name for name, p in less.parameters.items() if p.identifiable] == ["gain"]
    assert not any(p.identifiable for p in less.coefficients.values())
    assert not any(p.identifiable for p in within(found, 0.0).parameters.values())


@pytest.mark.slow
def test_a_candidate_of_which_nothing_is_identifiable_is_not_chosen_while_there_is_another():
    t, u, y = axis(np.random.default_rng(3), 300)
    task = Task(linear_record(t, u, y), 150, 2.3e-3, 0.02)
    tried = [Structure(2, 0, 1), Structure(1, 0, 1)]
    best, table = choose(task, tried, 0.02, lambda what, done: None, lambda f: f.structure == tried[1])
    assert best.structure == tried[1]
    assert {c.structure: c.against for c in table}[tried[0]] == "none of its numbers is identifiable"


def test_an_interval_that_says_nothing_is_not_printed_as_numbers():
    fit = identify_linear(record(MM_PER_M * move()[2], output_unit="mm"), structure=(2, 0, 1))
    wide = Parameter(-7.0, "1/s", -7e6, -7e-6, identifiable=False)
    rows = {row[0]: row for row in parameter_table(replace(fit, parameters={**fit.parameters, "pole 1": wide})).rows}
    assert rows["pole 1"][2:4] == ["–", "–"] and rows["pole 1"][-1] == "not identifiable"
    assert rows["b0"][2] != "–"
    assert stretch_table(fit).heads[3] == "rms (mm)"


@pytest.mark.parametrize(
    ("given", "delay", "ended"), [(None, 0.0985, False), (None, 0.0995, True), (None, 0.1, True), (0.1, 0.1, False)]
)
def test_a_delay_within_a_hundredth_of_the_longest_is_not_trusted_unless_it_was_given(given, delay, ended):
    task = Task(None, 1000, given, 0.1)
    assert late(task, SimpleNamespace(solved=SimpleNamespace(delay_s=delay))) is ended


def test_with_nothing_held_out_a_coefficient_must_earn_what_schwarz_asks_of_it():
    """BIC = n ln(rms^2) + k ln n: of 1,000 rows each of three more coefficients must lower it by 6.9."""
    task = Task(None, 1000, 0.0, 0.1)
    lean, rich = Structure(1, 0, 1), Structure(3, 1, 1)  # 0 and 3 coefficients beside gain and offset

    def scored(structure, rms):
        return _score(task, SimpleNamespace(structure=structure, train_rms=rms, holdout_rms=float("nan")))

    even = np.exp(-0.5 * 3.0 * np.log(1000.0) / 1000.0)
    assert scored(rich, 0.999 * even) < scored(lean, 1.0) < scored(rich, 1.001 * even)


def poles(damping, error):
    """Poles of s^2 + 2 damping 10 s + 100, the logarithm of the damping known to ``error``, that of 10 to 1e-9."""
    at = np.array([1.0, np.log(10.0), np.log(damping)])
    model = SimpleNamespace(
        m=0, split=lambda x: (x[:1], x[1:]), problem=SimpleNamespace(structure=Structure(2, 0, 0))
    )  # fmt: skip
    return {name: row[0] for name, row in _poles(model, at, np.diag([0.0, 1e-18, error**2])).items()}


def test_two_real_poles_are_told_apart_only_where_they_surely_are_no_pair():
    """s^2 + 25 s + 100 = (s + 5)(s + 20); a per cent of damping moves either pole by 1.25 / 0.75 per cent."""
    found = poles(1.25, 0.01)
    assert [found[k].value for k in ("pole 1", "pole 2")] == pytest.approx([-5.0, -20.0])
    reach = np.exp(1.96 * 0.01 * 1.25 / 0.75)
    for pole in found.values():
        assert (pole.low, pole.high) == pytest.approx((pole.value * reach, pole.value / reach), rel=1e-4)
    for damping, error in ((0.95, 0.01), (0.95, 0.1), (1.05, 0.1)):
        pair = poles(damping, error)
        assert pair["frequency 1"].value == pytest.approx(10.0 / (2.0 * np.pi))
        assert pair["damping 1"].value == pytest.approx(damping) and len(pair) == 2
