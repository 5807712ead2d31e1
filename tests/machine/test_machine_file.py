"""A machine in a file: read, refused, and taken wherever a study is."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from leadscrew import resolve
from leadscrew.cli import app
from leadscrew.identify.axis.result import AxisFit, Judged
from leadscrew.identify.estimation import Parameter
from leadscrew.machine import MachineFile, from_axis, from_linear, read, write
from leadscrew.machine.axis_study import controllers_of, loop_of, plant_of
from leadscrew.machine.gains import cascade
from leadscrew.machine.scenarios import of_log, scenarios
from leadscrew.util.errors import DataError, ValueRefused

SIDE = {"coulomb": 20.4, "static": 20.4, "viscous": 203.5, "stribeck_speed": 1e-3}
EMPS = MachineFile(
    name="emps", model="servo_axis", position_unit="mm", drive_unit="V", period=1e-3, drive=10.0, speed=127.0,
    acceleration=900.0, travel=(0.0, 246.0), resolution=1e-3, noise=1e-3, cascade={"kp": 160.18, "kv": 0.24345},
    parameters={"mass": 95.1, "force_per_drive": 35.15, "offset": -3.2}
    | {f"friction.{s}.{k}": v for s in ("forward", "backward") for k, v in SIDE.items()},
    intervals={"mass": (94.8, 95.4)}, identified={"source": "log.csv", "hold_out": {"rms_mm": 2.0}},
)  # fmt: skip


@pytest.fixture
def file(tmp_path) -> Path:
    write(tmp_path / "emps.toml", EMPS)
    return tmp_path / "emps.toml"


def said(*args):
    found = CliRunner().invoke(app, [str(a) for a in args])
    return found.exit_code, found.output


def test_what_is_written_is_read_back(file):
    assert read(file) == EMPS


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('model = "servo_axis"', 'model = "robot"', "model = 'robot': Input should be 'servo_axis'"),
        ("period = 0.001", "period = 0", "period = 0: Input should be greater than or equal to 0.000001"),
        ("period = 0.001", "perod = 0.001", "there is no key 'perod'; did you mean period"),
        ("speed = 127.0", "speed = -1", "limits.speed = -1: Input should be greater"),
        ("travel = [0.0, 246.0]", "travel = [246.0, 0.0]", "limits.travel = .*the lower first"),
        ("mass = 95.1", "mas = 95.1", "no parameter 'mas'|set.mass is missing"),
        ("mass = 95.1", "mass = -95.1", "mass = -95.1.*"),
        ("force_per_drive = 35.15", "force_per_drive = -35.15", "force_per_drive = -35.15: expected a number above 0"),
        ('position_unit = "mm"', 'position_unit = "furlong"', "position_unit = 'furlong': expected one of m, mm"),
        ('kind = "machine"', 'kind = "engine"', "kind"),
        ('name = "emps"', r'name = "emps\n#define X"', r"name = 'emps.n#define X': expected one line"),
        ('name = "emps"', r'name = "emps\u001b[2J"', "name = .*expected one line"),
        ("schema_version = 1", "schema_version = 2", "schema_version = 2"),
    ],
)
def test_a_file_that_is_wrong_is_refused_with_its_key(file, old, new, complaint):
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    with pytest.raises((DataError, ValueRefused), match=complaint) as refused:
        resolve.study(str(file))
    assert file.name in str(refused.value)


def test_it_is_a_study_for_the_commands(file):
    code, text = said("list", file)
    assert code == 0 and "ours.cascade_model" in text and "logged.cascade" in text and "reversal" in text
    code, text = said("simulate", file, "-s", "move", "-c", "ours.cascade_model", "--json")
    assert code == 0 and json.loads(text)["metrics"]["max_error"] < 0.02
    code, text = said("run", file)
    assert code == 2 and "no claims to judge" in text


def test_the_model_in_the_feed_forward_takes_most_of_the_following_error():
    own, asked = controllers_of(EMPS), scenarios(EMPS)["move"]
    worst = {
        name: loop_of(EMPS, plant_of(EMPS), block, asked).run(asked.duration_s).metrics.max_error
        for name, block in own.items()
    }
    assert worst["ours.cascade_model"] < 0.2 * worst["ours.cascade"] < 0.2 * worst["logged.cascade"]


def test_a_saved_run_of_a_machine_is_replayed_with_the_numbers_that_it_was_made_with(file, tmp_path):
    code, _ = said("simulate", file, "-s", "step", "-c", "ours.cascade", "--out", tmp_path / "run")
    assert code == 0
    assert json.loads((tmp_path / "run" / "run.json").read_text())["units"] == {
        "reference": "mm", "controller": "V", "plant": "mm"
    }  # fmt: skip
    code, text = said("replay", tmp_path / "run")
    assert code == 0 and "identical" in text
    file.write_text(file.read_text().replace("mass = 95.1", "mass = 99.1"))
    code, text = said("replay", tmp_path / "run")
    assert code == 0 and "identical" in text


@pytest.mark.slow
def test_first_gains_leave_the_speed_loop_a_phase_margin_of_60_degrees():
    """python-control on the plant without friction, with hold, difference and delay as dead time."""
    import control

    for delay in (0.0, 1.5e-3):
        machine = replace(EMPS, delay_s=delay, resolution=0.0)
        kpos, kvp, kvi, _ = cascade(replace(machine, noise=0.0))
        inertia = 95.1 / (35.15 * 1000.0)
        numerator, denominator = control.pade(delay + 1e-3, 6)
        late = control.tf(numerator, denominator)
        speed = control.tf([kvp, kvi], [1.0, 0.0]) * control.tf([1.0], [inertia, 0.0]) * late
        assert control.margin(speed)[1] == pytest.approx(60.0, abs=3.0)
        inner = speed / (1.0 + speed)
        assert control.margin(kpos * inner * control.tf([1.0], [1.0, 0.0]))[1] > 55.0


@pytest.mark.slow
@pytest.mark.parametrize("rough", [{"resolution": 0.05, "noise": 0.0}, {"noise": 0.01}, {"resolution": 0.1}])
def test_a_coarse_or_noisy_encoder_slows_the_loop_and_does_not_shake_the_drive(rough):
    machine = replace(EMPS, delay_s=1e-3, **rough)
    found = cascade(machine)
    size = max(machine.resolution, 3.0 * np.sqrt(2.0) * machine.noise)
    assert found.kvp < cascade(replace(EMPS, delay_s=1e-3)).kvp and found.filter_s > 0.0
    assert found.kvp * size / (EMPS.period + found.filter_s) == pytest.approx(0.05 * EMPS.drive)
    asked = scenarios(machine)["sine"]
    run = loop_of(machine, plant_of(machine), controllers_of(machine)["ours.cascade"], asked).run(asked.duration_s)
    assert run.metrics.rms_error < 0.05 * 24.6 and np.mean(np.abs(run["output"]) > 9.99) < 0.01


def fit(**changes) -> AxisFit:
    told = Parameter(1.0, "", 0.9, 1.1, "fitted", True)
    values = {"mass": 95.1, "offset": -3.2, "friction.forward.coulomb": 20.4, "friction.forward.viscous": 203.5,
              "friction.backward.coulomb": 21.4, "friction.backward.viscous": 201.0, "delay_s": 1.1e-3}  # fmt: skip
    parameters = {k: told._replace(value=v, low=0.99 * v, high=1.01 * v) for k, v in values.items()}
    parameters["force_per_drive"] = Parameter(35.15, "N/V", np.nan, np.nan, "given", True)
    empty = np.zeros(2)
    judged = Judged("hold-out", 12.0, 24.0, 2.5e-3, 5e-3, 1.0, 3.0, 5.0, 90.0, *[empty] * 5)
    base = AxisFit(
        source="log.csv", model="coulomb", symmetric=False, position_unit="m", drive_unit="V", period=1e-3,
        parameters=parameters, judged=[judged], condition=3.0, correlation={}, method="m", encoder_step=1e-6,
        noise=2e-6, top_speed=0.127, top_acceleration=0.9, travel=(0.0, 0.246), top_drive=5.0,
    )  # fmt: skip
    return replace(base, **changes)


def test_a_fit_becomes_a_machine_in_mm_with_its_delay_and_the_controller_of_the_log(tmp_path):
    machine = from_axis(fit(), "table", {"kp": 160.18, "kv": 243.45})
    assert machine.speed == pytest.approx(127.0) and machine.travel == pytest.approx((0.0, 246.0))
    assert machine.cascade == pytest.approx({"kp": 160.18, "kv": 0.24345})
    assert machine.delay_s == 1.1e-3 and "delay_s" not in machine.parameters
    assert machine.parameters["friction.backward.static"] == 21.4
    assert machine.identified["hold_out"]["rms_mm"] == pytest.approx(2.5)
    write(tmp_path / "table.toml", machine)
    found = resolve.study(str(tmp_path / "table.toml"))
    loop = found.loop("ours.cascade", "move")
    assert loop.sent == 11 and loop.step == pytest.approx(1e-4)
    assert loop.run(1.0).metrics.max_error < 1.0


@pytest.mark.slow
def test_a_fit_with_bristles_moves_too(tmp_path):
    more = {"friction.stiffness": 5e6, "friction.damping": 5e3, "friction.forward.static": 25.0}
    base = fit()
    told = base.parameters["mass"]
    parameters = base.parameters | {k: told._replace(value=v, low=v, high=v) for k, v in more.items()}
    machine = from_axis(replace(base, model="lugre", parameters=parameters), "table")
    write(tmp_path / "table.toml", machine)
    loop = resolve.study(str(tmp_path / "table.toml")).loop("ours.cascade_model", "step")
    assert machine.model == "servo_axis_lugre" and loop.run(0.5).diverged is None


def test_without_a_mass_there_is_no_machine():
    base = fit()
    unknown = {k: v for k, v in base.parameters.items() if k != "mass"}
    with pytest.raises(ValueRefused, match="does not tell the mass"):
        from_axis(replace(base, parameters=unknown), "table")


def test_a_linear_model_becomes_a_machine_that_a_pid_holds(tmp_path):
    told = {"numerator": [69380.0], "denominator": [1.0, 144.8, 166.3], "delay_s": 0.775e-3, "position_unit": "mm",
            "drive_unit": "V", "period": 5e-4, "resolution": 1e-4}  # fmt: skip
    limits = {"drive": 10.0, "speed": 200.0, "acceleration": 3000.0, "travel": [0.0, 100.0]}
    write(tmp_path / "xy.toml", from_linear(told, "xy", limits, "log.csv"))
    study = resolve.study(str(tmp_path / "xy.toml"))
    run = study.loop("ours.pid", "step").run(0.5)
    assert run.diverged is None and run.metrics.overshoot < 60.0
    assert abs(run["true_error"][-1]) < 0.02 * 0.1


@pytest.mark.slow
def test_what_the_log_leaves_open_is_what_tuning_has_to_bear(file, tmp_path):
    code, text = said("tune", file, "-c", "ours.cascade", "--vary", "controller.kpos=20:120", "--minimise", "rms_error",
                      "-s", "sine", "--over", "intervals", "--plants", "4", "--held-out", "4", "--budget", "20",
                      "--json", "-o", tmp_path / "tuned.toml")  # fmt: skip
    assert code == 0, text
    assert json.loads(text[text.index("{") :])["over"]["plant.mass"]
    code, text = said("simulate", file, "-c", tmp_path / "tuned.toml", "-s", "sine", "--json")
    assert code == 0
    code, text = said("montecarlo", "vud_lathe", "-c", "paper.vud", "--over", "intervals", "--runs", "8")
    assert code == 2 and "is no machine file" in text


@pytest.mark.slow
def test_controllers_as_they_are_are_compared_over_several_scenarios(file):
    code, text = said("compare", file, "-c", "ours.cascade", "-c", "ours.cascade_model", "-s", "reversal", "-s", "move",
                      "--minimise", "rms_error", "--unseen", "8", "--over", "intervals", "--json")  # fmt: skip
    assert code == 0, text


@pytest.fixture
def with_log(tmp_path):
    """A machine whose log holds a sine of 2 mm, logged from -1 mm on."""
    t = np.arange(2000) * 1e-3
    command = -1e-3 + 2e-3 * np.sin(2 * np.pi * t)
    rows = np.column_stack([t, command, command, np.cos(t)])
    header = "time [s],command [m],position [m],drive [V]"
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=header, comments="", fmt="%.9g")
    made = of_log(tmp_path / "log.csv", tmp_path, columns={"command": "command"})
    write(tmp_path / "emps.toml", replace(EMPS, log=made, identified={"seconds": 2.0}))
    return tmp_path / "emps.toml"


@pytest.mark.slow
def test_the_command_of_the_log_is_asked_for_again(with_log):
    study = resolve.study(str(with_log))
    assert study.scenarios["log"].duration_s == 2.0
    run = study.loop("ours.cascade_model", "log").run(2.0)
    assert run["command.position"][250] == pytest.approx(2.0, abs=1e-6)
    assert run["command.velocity"][500] == pytest.approx(-4.0 * np.pi, rel=1e-4)
    assert np.max(np.abs(run["true_error"][500:])) < 0.01  # it starts at full speed


def test_a_log_that_has_gone_or_changed_is_not_taken_for_the_old_one(with_log):
    study = resolve.study(str(with_log))
    log = with_log.parent / "log.csv"
    log.write_text(log.read_text() + "2,0,0,0\n")
    with pytest.raises(DataError, match="is not the log that emps was identified from"):
        study.loop("ours.cascade", "log")
    log.unlink()
    with pytest.raises(DataError, match="is not there"):
        study.loop("ours.cascade", "log")
    assert study.loop("ours.cascade", "step").run(0.1).diverged is None


def test_a_load_moves_the_axis_and_leaves_the_drive_room_or_is_not_offered():
    assert scenarios(EMPS)["load"].params.force == pytest.approx(61.2)
    gentle = scenarios(replace(EMPS, drive=1.0))["load"].params.force
    assert 20.4 < gentle < 35.15 - 3.2
    assert "load" not in scenarios(replace(EMPS, drive=0.65))
    smooth = EMPS.parameters | {
        f"friction.{s}.{k}": 0.0 for s in ("forward", "backward") for k in ("coulomb", "static")
    }
    assert scenarios(replace(EMPS, parameters=smooth))["load"].params.force > 50.0


@pytest.mark.parametrize(
    ("unit", "per"), [("m", 1.0), ("mm", 1000.0), ("um", 1e6), ("deg", 57.29578), ("mrad", 1000.0)]
)
def test_first_gains_by_hand_in_the_unit_of_the_machine(unit, per):
    """Delay and period of 1 ms: 0.4 / 2 ms = 200 rad/s of crossover, 50 1/s of position; 80 kg at 40 N a volt."""
    parameters = EMPS.parameters | {"mass": 80.0, "force_per_drive": 40.0}
    found = cascade(replace(EMPS, position_unit=unit, delay_s=1e-3, resolution=0.0, noise=0.0, parameters=parameters))
    assert found == pytest.approx((50.0, 400.0 / per, 10_000.0 / per, 0.0), rel=1e-6)


@pytest.mark.parametrize("offset", [-3.2, 3.2])
def test_a_load_leaves_the_drive_its_room_whichever_way_the_axis_pulls_at_rest(offset):
    """By hand, N: the drive makes 70.3; half of what 3.2 and static friction, 20.4, leave is 23.35, and 20.4 more."""
    machine = replace(EMPS, drive=2.0, parameters={**EMPS.parameters, "offset": offset})
    assert scenarios(machine)["load"].params.force == pytest.approx(43.75)
