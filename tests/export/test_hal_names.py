"""The HAL files as text: names that LinuxCNC and halcompile accept."""

from dataclasses import replace

import pytest

from leadscrew.export import hal
from leadscrew.export.core import Knob, Port
from leadscrew.util.errors import ValueRefused
from tests.export.hal_sample import core


def test_pins_have_the_names_of_stock_pid_and_others_those_of_their_ports():
    ports = [("command", "command"), ("command_velocity", "command-deriv"), ("x", "feedback"), ("force_n", "other")]
    assert hal.pins(ports) == ["command", "command-deriv", "feedback", "force-n"]


def test_a_port_or_knob_with_the_name_of_a_fixed_pin_gets_another():
    assert hal.pins([("enable", "other"), ("fault_", "other")]) == ["pin-enable", "pin-fault"]
    assert hal.parameters(["every", "force_n", "kp"], ["force-n"]) == ["knob-every", "knob-force-n", "kp"]


def test_a_name_that_hal_has_no_room_for_is_refused():
    with pytest.raises(ValueRefused, match="characters, and LinuxCNC allows names of 47"):
        hal.files(core("a_controller_with_quite_a_long_name"))


def test_quotes_and_greek_letters_do_not_reach_halcompile():
    made = hal.files(core("demo_q"))["demo_q.comp"]
    assert made.isascii()
    assert """"ours.demo_q: A PD with 'feedforward', in um or so.";""" in made


def test_every_pin_and_parameter_is_in_the_readme_with_unit_and_range():
    text = hal.readme(core("demo_r", rediscretisable=True))
    for name in (*hal.FIXED, "kp", "gains-kd", "mode"):
        if name not in ("command-accel", "inside", "time", "tmax", "tmax-increased"):
            assert f"`{name}`" in text, name
    assert "| `kp` | float rw | 1/mm | 0.25 | (0, inf) | duty per millimetre |" in text


def test_rediscretise_is_offered_only_where_the_controller_allows_it():
    assert "rediscretise" not in hal.files(core("demo_r"))["demo_r.comp"]
    assert "rediscretise" not in hal.readme(core("demo_r"))
    assert "param rw bit rediscretise" in hal.files(core("demo_r", rediscretisable=True))["demo_r.comp"]


def test_a_controller_in_micrometres_is_scaled_in_the_example():
    made = core("demo_u")
    inputs = tuple(replace(p, unit=p.unit.replace("mm", "µm")) for p in made.inputs)
    text = hal.files(replace(made, inputs=inputs))["demo_u_example.hal"]
    assert "setp unit.x.feedback.gain 1000.0" in text
    assert "net x-pos-cmd-scaled unit.x.command.out => demo-u.x.command" in text


def test_further_outputs_and_inputs_have_pins(tmp_path):
    made = core("demo_m")
    ports = (*made.outputs, Port("brake", "brake", "output", "N", "brake force"))
    text = hal.files(replace(made, outputs=ports, knobs=(Knob("r", "r", "float", 1e-05, ("r",)),)))["demo_m.comp"]
    assert 'pin out float brake "brake force, N";' in text
    assert "*inst->brake = m->brake;" in text
    assert "param rw float r = 1e-05" in text
