"""How an exported controller starts: what inputs hold that nothing is connected to, and from which state."""

import ctypes
import subprocess
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from leadscrew import Doc, Loop, Unit, controller, plant
from leadscrew.export import fmu, hal
from leadscrew.export.controller import export_controller
from leadscrew.export.fmu import model_description, variables
from leadscrew.references._step import step
from tests.tools import missing, needed

PERIOD = 0.01


class Gain(NamedTuple):
    k: float = 2.0


class Sum(NamedTuple):
    total: float = 3.0


class Reading(NamedTuple):
    angle: Annotated[float, Unit("deg"), Doc("angle of the cut")] = 0.0
    seen: Annotated[float, Doc("1; 0 while nothing is seen")] = 1.0


class Place(NamedTuple):
    x: float = 0.0


def align(p, command, feedback, output):
    return Sum(output - p.k * (command - feedback.angle))


@controller(Gain(), Sum(), align=align, unit="deg")
def watcher(p, s, command, feedback):
    """Gives the sum plus a share of the error; nothing while the angle is not seen."""
    error = command - feedback.angle
    return Sum(s.total + 0.1 * error), s.total + p.k * error if feedback.seen > 0.5 else 0.0


def shown(s):
    return Reading(s.x, 1.0)


@plant(None, Place(), unit="deg", output=shown)
def turntable(s, u, dt):
    return Place(s.x + 0.01 * u)


@plant(None, Place(), unit="deg", output=shown, sense=-1)
def mirrored(s, u, dt):
    return Place(s.x - 0.01 * u)


def exported(machine=turntable, **gains):
    loop = Loop(reference=step(target=1.0), controller=watcher(**gains), plant=machine, period=PERIOD, engine="python")
    return export_controller(loop, 0.3, name="watcher", title="watcher")


@pytest.fixture(scope="module")
def made():
    return exported()


def test_a_flag_has_no_unit_of_the_axis_and_an_unconnected_one_does_not_blind_the_controller(made):
    core, _ = made
    found = {v.name: (v.start, v.unit) for v in variables(core) if v.causality == "input"}
    assert found["feedback_seen"] == (1.0, "")
    assert found["feedback_angle"] == (0.0, "deg") and found["command"] == (0.0, "deg")
    description = model_description(core, variables(core), 3, "", [])
    assert 'name="feedback_seen"' in description and 'start="1.0"' in description


def test_an_unconnected_pin_of_hal_does_not_blind_the_controller(made):
    core, _ = made
    files = hal.files(core)
    component = files["watcher.comp"]
    assert "pin in float feedback_seen = 1.0 " in component.replace("feedback-seen", "feedback_seen")
    assert "pin in float feedback " in component
    assert "`bumpless` | bit rw" in hal.readme(core)


def test_an_fmu_with_nothing_set_gives_the_bits_of_the_simulation(made, tmp_path):
    """The unit's own C, called as an importer calls it: only command and angle are set, all else is left alone."""
    import shutil

    if shutil.which("gcc") is None:
        missing("gcc", "not installed")
    core, record = made
    shown_variables = variables(core)
    for name, text in fmu.sources(core, 2, shown_variables, "token").items():
        (tmp_path / name).write_text(text)
    library = tmp_path / "unit.so"
    c_files = [str(f) for f in tmp_path.glob("*.c")]
    subprocess.run(
        ["gcc", "-std=c99", "-O0", "-ffp-contract=off", "-fPIC", "-shared", "-o", library, *c_files, "-lm"], check=True
    )
    unit = ctypes.CDLL(str(library))
    log = ctypes.CFUNCTYPE(None)

    class Callbacks(ctypes.Structure):
        _fields_ = [(n, ctypes.c_void_p) for n in ("log", "allocate", "free", "finished", "environment")]

    libc = ctypes.CDLL(None)
    libc.calloc.restype = ctypes.c_void_p
    callbacks = Callbacks(
        ctypes.cast(log(lambda: None), ctypes.c_void_p),
        ctypes.cast(libc.calloc, ctypes.c_void_p),
        ctypes.cast(libc.free, ctypes.c_void_p),
    )
    unit.fmi2Instantiate.restype = ctypes.c_void_p
    instance = ctypes.c_void_p(unit.fmi2Instantiate(b"u", 1, b"token", b"", ctypes.byref(callbacks), 0, 0))
    assert instance
    unit.fmi2SetupExperiment(instance, 0, ctypes.c_double(0), ctypes.c_double(0), 0, ctypes.c_double(0))
    assert unit.fmi2EnterInitializationMode(instance) == 0 and unit.fmi2ExitInitializationMode(instance) == 0
    number = {v.name: v.reference for v in shown_variables}
    references = (ctypes.c_uint * 2)(number["command"], number["feedback_angle"])
    out = (ctypes.c_uint * 1)(number["output"])
    got = []
    columns = [p.name for p in core.inputs]
    wanted = [columns.index("command"), columns.index("feedback_angle")]
    for k, row in enumerate(record.inputs[:, wanted]):
        assert unit.fmi2SetReal(instance, references, 2, (ctypes.c_double * 2)(*row)) == 0
        assert unit.fmi2DoStep(instance, ctypes.c_double(k * PERIOD), ctypes.c_double(PERIOD), 1) == 0
        value = (ctypes.c_double * 1)()
        assert unit.fmi2GetReal(instance, out, 1, value) == 0
        got.append(value[0])
    assert record.outputs[0, 0] == 5.0  # the start state's 3 and twice the error of 1: no jump-free start gives that
    assert np.array_equal(got, record.outputs[:, 0])


def test_a_controller_on_a_reversed_drive_is_turned_for_the_machine_whatever_its_own_sheet_says():
    """A plain controller with a negative gain on a reversed plant: at the machine positive must move to positive."""
    core, record = exported(mirrored, k=0.0)
    assert exported()[0].sense == 1 and watcher.sense == 1
    assert core.sense == -1 and core.manifest["sense"] == -1
    assert np.array_equal(core.machine_outputs(record), -record.outputs)


@pytest.mark.slow
def test_the_recipe_for_fmpy_gives_the_bits_of_the_network_s_simulation(tmp_path):
    """Every row of the network's record, as the page on export plays it: 925 rows, none of them different."""
    needed("fmpy", "verify")
    from fmpy import simulate_fmu
    from typer.testing import CliRunner

    from leadscrew.cli import app

    folder = tmp_path / "knife"
    args = [
        "export",
        "sofnn_tangent",
        "-c",
        "ours.sofnn_tuned",
        "-s",
        "wave_fabric",
        "-t",
        "fmu3",
        "--out",
        str(folder),
    ]
    assert CliRunner().invoke(app, args).exit_code == 0
    golden = np.genfromtxt(folder / "golden.csv", delimiter=",", names=True)
    for left_out in ((), ("feedback_seen",)):
        inputs = [n for n in golden.dtype.names[:-1] if n not in left_out]
        time = PERIOD * np.arange(len(golden))
        given = np.rec.fromarrays([time, *(golden[n] for n in inputs)], names=["time", *inputs])
        got = simulate_fmu(
            str(folder / "sofnn_tuned.fmu"), stop_time=PERIOD * len(golden), step_size=PERIOD, output_interval=PERIOD,
            input=given, output=["output", "fault"],
        )  # fmt: skip
        assert len(golden) > 100 and np.array_equal(got["output"][1:], golden["output"])
        assert not got["fault"].any()
