"""The HAL component in use, in the real LinuxCNC: periods, parameters, instances and the files around it."""

import re

import numpy as np
import pytest

from leadscrew.export import hal, hal_run
from tests.export import hal_sample
from tests.export.hal_bench import Bench, needed, shown


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    needed()
    with hal_run.workplace() as place:
        yield Bench(place, tmp_path_factory.mktemp("hal"))


def test_in_a_thread_twice_as_fast_it_runs_at_every_second_call(bench):
    inputs, outputs = bench.record("demo_down")
    read = ["show param demo-down.0.every"]
    got = bench.stream("demo_down", np.repeat(inputs, 2, axis=0), thread_ns=500_000, after=read)
    assert (got.outputs == np.repeat(outputs, 2, axis=0)).all()
    assert "s32 RO 2 demo-down.0.every" in shown(got.printed)


def test_between_its_steps_a_stop_takes_effect_at_once(bench):
    inputs, _ = bench.record("demo_down", 200)
    enable = np.ones(200, dtype=bool)
    enable[101:] = False
    got = bench.stream("demo_down", inputs, bits={"enable": enable}, thread_ns=250_000)
    assert got.outputs[100] != 0
    assert (got.outputs[101:] == 0).all()


def test_a_period_that_does_not_suit_is_a_fault_and_one_within_a_percent_is_not(bench):
    inputs, outputs = bench.record("demo_down", 200)
    got = bench.stream("demo_down", inputs, thread_ns=700_000)
    assert (got.outputs == 0).all()
    assert (got.faults == 4).all()
    assert "designed for a period of 1000000 ns, but the thread calls it every 700000 ns" in got.printed
    near = bench.stream("demo_down", inputs, thread_ns=995_000)
    assert (near.faults == 0).all()
    assert (near.outputs == outputs).all()


def test_rediscretised_it_runs_at_the_period_of_the_thread(bench):
    core = bench.cores["demo_any"]
    recorded = hal_sample.record(core, 500, period=700_000 * 1e-9)
    setup = ["setp demo-any.0.rediscretise 1"]
    got = bench.stream("demo_any", recorded.inputs, setup=setup, thread_ns=700_000)
    assert (got.faults == 0).all()
    assert (got.outputs == core.machine_outputs(recorded)).all()
    assert (bench.stream("demo_any", recorded.inputs, thread_ns=700_000).faults == 4).all()


def test_a_command_deriv_that_nothing_is_connected_to_is_derived_with_a_warning(bench):
    inputs, _ = bench.record("demo_down", 300)
    command, feedback = inputs[:, 0], inputs[:, 2]
    slope = np.concatenate([[0.0], np.diff(command) / 0.001])
    alone = bench.replay("demo_down", {"command": command, "feedback": feedback})
    given = bench.stream("demo_down", np.column_stack([command, slope, feedback]))
    warning = "demo-down.0.command-deriv is not connected: it is derived from command"
    assert (alone.outputs == given.outputs).all()
    assert alone.printed.count(warning) == 1
    assert warning not in given.printed


@pytest.mark.parametrize(
    ("knob", "value"),
    [("kp", "nan"), ("kp", "0"), ("kp", "inf"), ("gains-kd", "1.01"), ("mode", "4"), ("maxoutput", "-1")],
)
def test_a_parameter_out_of_its_range_never_reaches_the_controller(bench, knob, value):
    inputs, outputs = bench.record("demo_down", 100)
    read = ["show pin demo-down.0.bad-parameter"]
    got = bench.stream("demo_down", inputs, setup=[f"setp demo-down.0.{knob} {value}"], after=read)
    assert (got.outputs == outputs).all()
    assert got.printed.count(f"demo-down.0.{knob} must be a number in") == 1
    assert "bit OUT TRUE demo-down.0.bad-parameter" in shown(got.printed)


def test_two_instances_keep_their_own_state_and_parameters(bench):
    sides = ("left", "right")
    lines = [
        "loadrt demo_up names=left,right",
        *(f"addf {side} servo" for side in sides),
        *(f"setp {side}.{pin} 1" for side in sides for pin in ("enable", "command")),
        "setp right.kp 0.0625",
        "setp right.command 2",
    ]
    table, _ = bench.sampled(lines, [f"{side}.output" for side in sides], 5)
    assert table.tolist() == [[0.25, 0.125]] * 5


def test_the_demonstration_runs_and_follows_its_command(bench):
    script = hal.files(bench.cores["demo_down"])["demo_down_sim.hal"]
    text = shown(hal_run.run(bench.place, script, speed=50))
    pins = {name: float(value) for value, name in re.findall(r"float (?:OUT|IN) (\S+) demo-down\.0\.(\S+)", text)}
    assert "bit OUT FALSE demo-down.0.fault " in text
    # Where in the sine the reading falls is chance, and its pins are not read in one instant.
    amplitude = float(re.search(r"siggen.0.amplitude (\S+)", script)[1])
    assert abs(pins["error"]) < 0.1 * amplitude
    assert pins["feedback"] != 0
    assert pins["output"] != 0


def test_the_example_loads_beside_linuxcnc_s_motion_controller(bench):
    lines = [
        "loadrt homemod",
        "loadrt tpmod",
        "loadrt trivkins coordinates=X",
        "loadrt motmod servo_period_nsec=1000000 num_joints=1",
        "addf motion-command-handler servo-thread",
        "addf motion-controller servo-thread",
        hal.files(bench.cores["demo_down"])["demo_down_example.hal"],
        "start",
        "loadusr -w sleep 1",
        "show pin",
    ]
    text = shown(hal_run.run(bench.place, "\n".join(lines) + "\n"))
    assert "joint.0.vel-cmd ==> x-vel-cmd" in text
    assert "demo-down.x.command-deriv <== x-vel-cmd" in text
    assert "bit OUT FALSE demo-down.x.fault ==> x-fault" in text
    assert "joint.0.index-enable <=> x-index-enable" in text
