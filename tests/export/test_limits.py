"""The limits that an export carries to the machine, worked by hand, and the plant of its HAL demonstration."""

import math
import re
import sys
from dataclasses import replace

import numpy as np
import pytest

from leadscrew.export import hal
from leadscrew.export.controller import limits_of, rounded_up
from leadscrew.export.core import Knob, Limits, Record, at_the_machine
from tests.export import hal_sample

# Command, feedback and output, period by period, and the way against the output. The output of a period moves the axis
# in the next one; the first move, of 0.01, is the smallest step, and 100 of those are 1.
RUNS = {
    # 1 + 2 + 3; the move of 2.5 is slower than the one before; then the output is turned round.
    "away from the command": (
        [(10, 0, 0), (10, 0.01, 1), (10, -0.99, 1), (10, -2.99, 1), (10, -5.99, 1), (10, -8.49, -1), (10, -18.49, 1)],
        6.0,
    ),
    # The move of 9 comes with a command on the other side: the output was not for that.
    "a command that changes sides": ([(10, 0, 0), (10, 0.01, 1), (10, -1.99, 1), (-40, 7.01, -1)], 2.0),
    # There the output was for the new side already, and the move of 9 is against it, too: 2 + 9.
    "an output that is first": ([(10, 0, 0), (10, 0.01, 1), (10, -1.99, -1), (-40, 7.01, -1)], 11.0),
    "no output": ([(-10, 0, 0), (-10, 0.01, 0), (-10, 3.01, -1), (-10, 0.01, 0)], 0.0),
}


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("run", RUNS)
def test_an_export_allows_twice_the_recorded_error_and_twice_the_way_against_the_output(run, sense):
    rows, way = RUNS[run]
    command, feedback, output = np.array(rows, dtype=float).T
    core = replace(hal_sample.core("axis", sense=sense), full_scale=0.3)
    # Columns as the core's inputs: command, its velocity, feedback. The output in the controller's own signs.
    record = Record(np.column_stack([command, 0.0 * command, feedback]), sense * output[:, None])
    error = max(abs(c - f) for c, f, _ in rows)
    wrong_way = max(2.0 * way + error / 20.0, 1.0)
    found = limits_of(core, record)
    assert found.max_output == 0.3
    # Rounded up to two digits: at most a tenth more.
    assert 2.0 * error <= found.max_error <= 2.2 * error
    assert wrong_way * (1.0 - 1e-12) <= found.max_wrong_way <= 1.1 * wrong_way


def test_the_noise_of_an_encoder_is_no_fault_at_rest():
    count = 0.02 * (np.arange(40) % 2)
    inputs = np.column_stack([np.zeros(40), np.zeros(40), count])
    # Way against the output: never more than one count; 2 * 0.02 + 0.05 * 0.02 = 0.041 is less than 100 counts.
    assert limits_of(hal_sample.core("axis"), Record(inputs, -np.ones((40, 1)))) == Limits(1.0, 0.04, 2.0)


@pytest.mark.parametrize(
    ("value", "expected"), [(0.0, 0.0), (-1.0, 0.0), (15.0, 15.0), (15.01, 16.0), (0.0991, 0.1), (123.0, 130.0)]
)
def test_a_limit_is_rounded_up_to_two_digits(value, expected):
    assert rounded_up(value) == expected


def test_golden_outputs_have_the_machine_s_sign_and_keep_to_its_largest_output():
    outputs = np.array([[0.1], [-0.4], [0.7]])
    assert at_the_machine(outputs, -1, 0.5, "double").tolist() == [[-0.1], [0.4], [-0.5]]
    assert at_the_machine(outputs, 1, 0.0, "double").tolist() == outputs.tolist()
    assert at_the_machine(outputs, 1, 0.2, "float")[2, 0] == float(np.float32(0.2))


# ---- the plant of the demonstration
def demonstrated(drive, unit="mm", steps=100):
    """Where the plant of ``NAME_sim.hal`` is after every period at full drive, by the equations of HAL's manual.

    lowpass: out += gain (in - out); integ: out += gain in dt.
    """
    core = hal_sample.core("axis")
    inputs = (replace(core.inputs[0], unit=unit), *core.inputs[1:])
    text = hal.files(replace(core, drive=drive, full_scale=2.0, inputs=inputs))["axis_sim.hal"]
    gain = {name: float(value) for name, value in re.findall(r"^setp (\w+)\.gain (\S+)$", text, re.MULTILINE)}
    lowpass = re.findall(r"^loadrt lowpass names=(\w+)$", text, re.MULTILINE)
    integ = re.findall(r"^loadrt integ names=(\w+)$", text, re.MULTILINE)
    value = dict.fromkeys([*lowpass, *integ], 0.0)
    places = []
    for _ in range(steps):
        signal = 2.0
        for name in lowpass:
            value[name] += gain[name] * (signal - value[name])
            signal = value[name]
        for name in integ:
            value[name] += gain[name] * signal * core.period
            signal = value[name]
        places.append(signal)
    return np.array(places)


def test_the_demonstration_s_axis_comes_to_its_full_speed_with_the_time_constant_that_it_prints():
    # T = 0.1 s, 100 periods of 1 ms: x = v (t - T (1 - exp(-t / T))), v = 200 mm/s; 2 % for Euler's steps.
    assert demonstrated("torque")[-1] == pytest.approx(200.0 * 0.1 * math.exp(-1.0), rel=0.02)
    assert demonstrated("force", "um")[-1] == pytest.approx(200e3 * 0.1 * math.exp(-1.0), rel=0.02)


def test_the_demonstration_s_axis_moves_at_100_mm_in_a_second_at_full_drive():
    assert demonstrated("velocity")[-1] == pytest.approx(10.0, rel=1e-12)
    assert demonstrated("velocity", "m")[-1] == pytest.approx(0.01, rel=1e-12)


def test_the_demonstration_s_axis_follows_a_position_with_the_lag_that_it_prints():
    # T = 20 ms: after 20 periods 1 - 1 / e of the way; 0.03 for Euler's steps (1 - 0.95^20 is 0.6415).
    assert demonstrated("position", steps=20)[-1] == pytest.approx(2.0 * (1.0 - math.exp(-1.0)), abs=0.03)


@pytest.mark.parametrize(("period", "nanoseconds"), [(1e-3, 1_000_000), (0.25e-3, 250_000), (1.0 / 3000.0, 333_333)])
def test_the_demonstration_s_thread_has_the_period_of_the_controller(period, nanoseconds):
    text = hal.files(replace(hal_sample.core("axis"), period=period))["axis_sim.hal"]
    assert f"loadrt threads name1=servo period1={nanoseconds}\n" in text


# ---- the ranges of parameters in HAL
FREE = Knob("x", "x", "float", 1.0, ("x",))


@pytest.mark.parametrize(
    ("change", "taken", "refused"),
    [
        ({}, (-1e308, 0.0, 1e308), (-math.inf, math.inf, math.nan)),
        ({"low": 0.0, "range": "[0, inf)"}, (0.0, 1e308), (-1e-9, math.inf, math.nan)),
        ({"low": 0.0, "range": "(0, inf)"}, (5e-324, 1.0), (0.0, -1.0, math.nan)),
        ({"low": -1.0, "high": 2.0, "range": "[-1, 2]"}, (-1.0, 2.0), (-1.0000001, 2.0000001)),
        ({"low": -1.0, "high": 2.0, "range": "(-1, 2)"}, (-0.9999999, 1.9999999), (-1.0, 2.0)),
        ({"kind": "int", "value": 1, "low": 0, "high": 3, "range": "[0, 3]"}, (0, 3), (-1, 4)),
        ({"kind": "int", "value": 1, "low": 2, "high": math.inf, "range": "[2, inf)"}, (2, 2**31 - 1), (1, -(2**31))),
        ({"kind": "int", "value": 1}, (-(2**31), 2**31 - 1), ()),
        ({"kind": "bool", "value": True}, (0, 1), ()),
    ],
)
def test_hal_refuses_a_parameter_outside_of_its_range_and_takes_its_closed_ends(change, taken, refused):
    core = replace(hal_sample.core("axis"), knobs=(replace(FREE, **change),))
    text = hal.files(core)["axis.comp"]
    # The condition between the reading of the pin and the refusal, in the words of Python.
    found = re.search(r"= (?:\(\w+\))?inst->x(?: != 0)?;\s*if \((.*)\) \{\n\s*bad = 1", text)
    condition = found[1] if found else "0"
    for c, python in (("&&", " and "), ("||", " or "), ("!(", "not (")):
        condition = condition.replace(c, python)
    names = {"DBL_MAX": sys.float_info.max}
    assert not any(eval(condition, {**names, "wanted": x}) for x in taken)
    assert all(eval(condition, {**names, "wanted": x}) for x in refused)
