"""How an FMU behaves in FMPy, call by call."""

import numpy as np
import pytest

from leadscrew.export import fmu
from tests.export.fmu_sample import PERIOD, Unit, core, record, unpacked
from tests.tools import missing, needed

RUN = record()


@pytest.fixture(params=[2, 3], scope="module")
def make(request):
    """Makes instances of one unpacked FMU."""
    needed("fmpy", "verify")
    import shutil

    if not shutil.which("gcc"):
        missing("gcc", "gcc is not installed")
    with unpacked(fmu.build(core(), request.param, "gcc")) as folder:
        units = []

        def one():
            units.append(Unit(folder, request.param))
            return units[-1]

        yield one
        for unit in units:
            unit.fmi.freeInstance()


def bits(x: np.ndarray) -> list[int]:
    return np.ascontiguousarray(x).view(np.int64).ravel().tolist()


EXPECTED = core().machine_outputs(RUN)


def refused(unit, call, capsys) -> str:
    """The message with which a call is refused."""
    capsys.readouterr()
    with pytest.raises(Exception, match=r"failed with status 3 \(error\)"):
        call()
    return capsys.readouterr().out


def test_three_thousand_rows_are_the_same_bits(make):
    assert bits(make().begin().play(RUN.inputs)) == bits(EXPECTED)
    assert 0 < np.count_nonzero(np.abs(EXPECTED) == 0.75) < 3000, (
        "the record should reach max_output, and not stay there"
    )


@pytest.mark.parametrize("version", [2, 3])
def test_single_precision_gives_the_bits_of_single_precision(version):
    needed("fmpy", "verify")
    of, run = core("float"), record(3000, "float")
    with unpacked(fmu.build(of, version, "gcc")) as folder:
        unit = Unit(folder, version).begin()
        got = unit.play(run.inputs)
        assert unit.get("kp") == 0.25 and unit.get("gains.kd") == float(np.float32(0.004))
        unit.set("gains.kd", float(np.float32(0.1)))
        unit.fmi.freeInstance()
    assert bits(got) == bits(of.machine_outputs(run))
    assert bits(got) != bits(EXPECTED)


def test_one_knob_changed_by_one_ulp_is_seen(make):
    unit = make().begin(kp=float(np.nextafter(0.25, 1.0)))
    got = unit.play(RUN.inputs)
    assert sum(a != b for a, b in zip(bits(got), bits(EXPECTED), strict=True)) > 0
    assert np.allclose(got, EXPECTED, atol=1e-12)


def test_parameters_hold_exactly_what_was_set_in_all_their_places(make):
    unit = make().begin(kp=0.1, gains__kd=0.05, mode=3)
    assert (unit.get("kp"), unit.get("gains.kd"), unit.get("mode")) == (0.1, 0.05, 3)
    unit.set("command", 1.0)
    unit.step()
    assert unit.get("output") == 0.1, "the sign turns where a place is left out"
    unit.set("parameters.enable", True)
    unit.step()
    assert unit.get("output") == 0.0


def test_a_saved_state_brings_the_same_bits_again(make):
    unit = make().begin()
    unit.play(RUN.inputs[:1500])
    state = unit.fmi.getFMUState()
    first = unit.play(RUN.inputs[1500:])
    unit.play(RUN.inputs[:77] + 1.0)
    unit.fmi.setFMUState(state)
    unit.time = 1500 * PERIOD
    assert bits(unit.play(RUN.inputs[1500:])) == bits(first) == bits(EXPECTED[1500:])
    unit.fmi.freeFMUState(state)


def test_a_state_travels_as_bytes_to_another_instance(make, capsys):
    one, other = make().begin(kp=0.2), make().begin()
    one.play(RUN.inputs[:1000])
    packed = one.fmi.serializeFMUState(one.fmi.getFMUState())
    other.fmi.setFMUState(other.fmi.deserializeFMUState(packed))
    other.time = one.time
    assert other.get("kp") == 0.2
    assert bits(other.play(RUN.inputs[1000:])) == bits(one.play(RUN.inputs[1000:]))
    broken = b"x" + packed[1:]
    assert "not a state of this unit" in refused(other, lambda: other.fmi.deserializeFMUState(broken), capsys)
    assert "not a state of this unit" in refused(other, lambda: other.fmi.deserializeFMUState(packed[:-1]), capsys)


def test_two_instances_do_not_disturb_one_another(make):
    one, other = make().begin(), make().begin(kp=0.5)
    rows = []
    for row in RUN.inputs[:500]:
        rows.append(one.play(row[None])[0])
        other.play(-row[None])
    assert bits(np.array(rows)) == bits(EXPECTED[:500])
    assert (one.get("kp"), other.get("kp")) == (0.25, 0.5)


@pytest.mark.parametrize("size", [1.5, 0.5, 1 + 3e-9, 0.0, -1.0, 1e12, float("nan")])
def test_a_step_that_is_no_multiple_of_the_period_is_refused_with_both_numbers(make, size, capsys):
    unit = make().begin()
    before = unit.play(RUN.inputs[:10])[-1, 0]
    told = refused(unit, lambda: unit.step(size), capsys)
    assert f"{size * PERIOD:.12g} s" in told and "control period of 0.001 s" in told
    assert unit.get("output") == before
    assert bits(unit.play(RUN.inputs[10:50])) == bits(EXPECTED[10:50])


def test_a_step_of_several_periods_is_that_many_with_the_inputs_held(make):
    unit, slow = make().begin(), make().begin()
    for row in RUN.inputs[:40]:
        held = slow.play(np.repeat(row[None], 7, axis=0))[-1, 0]
        for name, value in zip(("command", "command_velocity", "feedback"), row.tolist(), strict=True):
            unit.set(name, value)
        unit.step(7)
        assert unit.get("output") == held


def test_a_step_taken_as_the_difference_of_late_times_is_no_surprise(make, capsys):
    unit = make()
    if unit.second:
        unit.fmi.setupExperiment(startTime=36000.0)
        unit.fmi.enterInitializationMode()
    else:
        unit.fmi.enterInitializationMode(startTime=36000.0)
    unit.fmi.exitInitializationMode()
    now = 36000.0
    for k in range(1, 200):
        later = 36000.0 + k * PERIOD
        unit.fmi.doStep(now, later - now)
        now = later
    assert capsys.readouterr().out == ""


def test_a_gap_in_time_is_told_once_and_does_not_stop(make, capsys):
    unit = make().begin()
    unit.step()
    unit.time += 5 * PERIOD
    unit.step()
    unit.time += 5 * PERIOD
    unit.step()
    told = capsys.readouterr().out
    assert told.count("does not see the gap") == 1
    assert "0.006 s" in told and "0.001 s" in told


@pytest.mark.parametrize(
    ("name", "value", "range"),
    [
        ("gains.kd", 0.1000001, "[0, 0.1]"),
        ("gains.kd", -5e-324, "[0, 0.1]"),
        ("tau.'0'", 0.0, "(0, 1)"),
        ("tau.'0'", 1.0, "(0, 1)"),
        ("kp", float("inf"), "[0, inf)"),
        ("kp", float("nan"), "[0, inf)"),
        ("mode", 4, "[0, 3]"),
        ("mode", -1, "[0, 3]"),
        ("limits.max_output", -1.0, "[0, inf)"),
    ],
)
def test_a_parameter_out_of_range_is_refused_and_kept(make, name, value, range, capsys):
    unit = make().begin()
    before = unit.get(name)
    told = refused(unit, lambda: unit.set(name, value), capsys)
    assert f"{name} = " in told and range in told
    assert unit.get(name) == before
    unit.step()


def test_outputs_and_unknown_references_cannot_be_set(make, capsys):
    unit = make().begin()
    assert "value reference 6: no variable of the kind real number that can be set" in refused(
        unit, lambda: unit.set("output", 1.0), capsys
    )
    get = unit.fmi.getReal if unit.second else unit.fmi.getFloat64
    assert "value reference 999" in refused(unit, lambda: get([999]), capsys)


def test_disabled_gives_zero_and_enabled_again_starts_afresh(make):
    unit = make().begin()
    unit.play(RUN.inputs[:300])
    unit.set("enable", False)
    assert not unit.play(RUN.inputs[300:350]).any()
    unit.set("enable", True)
    assert bits(unit.play(RUN.inputs[:300])) == bits(EXPECTED[:300])


def test_a_number_that_is_none_holds_the_outputs_at_zero_until_enable_is_taken_away(make):
    unit = make().begin()
    assert unit.play(RUN.inputs[:300])[-1, 0] != 0.0
    unit.set("feedback", float("nan"))
    unit.step()
    assert (unit.get("output"), bool(unit.get("fault")), unit.get("fault_code")) == (0.0, True, 1)
    assert not unit.play(RUN.inputs[300:310]).any()
    unit.set("enable", False)
    unit.step()
    unit.set("enable", True)
    unit.play(RUN.inputs[:1])
    assert not unit.get("fault") and unit.get("fault_code") == 0


def test_limits_are_parameters(make):
    unit = make().begin(limits__max_output=0.125, limits__max_error=3.0)
    unit.set("command", 2.0)
    unit.step()
    assert (unit.get("output"), bool(unit.get("saturated")), unit.get("error")) == (0.125, True, 2.0)
    unit.set("command", 3.5)
    unit.step()
    assert (unit.get("output"), unit.get("fault_code")) == (0.0, 2)


def test_the_command_can_be_differentiated_inside(make):
    outside, inside = make().begin(), make().begin(derive_command_velocity=True)
    for k in range(20):
        for unit in (outside, inside):
            unit.set("command", 0.01 * k)
        outside.set("command_velocity", (0.01 * k - 0.01 * (k - 1)) / PERIOD if k else 0.0)
        outside.step()
        inside.step()
        assert inside.get("output") == outside.get("output")


def test_reset_brings_back_the_start(make):
    unit = make().begin(kp=0.5)
    unit.set("enable", False)
    unit.play(RUN.inputs[:100])
    unit.fmi.reset()
    assert (unit.get("kp"), bool(unit.get("enable")), unit.get("command")) == (0.25, True, 0.0)
    assert bits(unit.begin().play(RUN.inputs[:500])) == bits(EXPECTED[:500])


def test_calls_out_of_order_are_refused_with_a_reason(make, capsys):
    unit = make()
    unit.time = 0.0
    assert "initialised" in refused(unit, unit.step, capsys)
    assert "not been entered" in refused(unit, unit.fmi.exitInitializationMode, capsys)
    unit.begin()
    unit.step()
    unit.fmi.terminate()
    assert "not terminated" in refused(unit, unit.step, capsys)
    assert unit.get("output") == 0.0
    unit.fmi.reset()
    unit.begin().step()


def test_a_description_of_another_export_does_not_load(make, capsys):
    unit = make()
    unit.fmi.guid = "{00000000-0000-0000-0000-000000000000}"
    with pytest.raises(Exception, match="instantiate"):
        unit.fmi.instantiate()
    assert "belongs to another export" in capsys.readouterr().out
