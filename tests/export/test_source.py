"""The exported core: it compiles as C and from C++, takes every knob, aligns, and gives the bits of its loop."""

import ctypes
import shutil
import subprocess
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew.export.controller import export_controller
from leadscrew.export.core import Core
from leadscrew.kernel.block import controller, make
from leadscrew.kernel.loop import Loop
from leadscrew.util.errors import BlockError, SubsetError
from tests.kernel import nasty, printed, zoo
from tests.tools import missing

CPP = ("g++", "-Wall", "-Wextra", "-pedantic", "-Werror")


class CounterParams(NamedTuple):
    """Parameters with the names of what the exporter adds itself."""

    period: float = 2.0
    int: float = 0.5
    many: "int" = 3


class CounterState(NamedTuple):
    periods: float = 1.0
    past: np.ndarray = np.array([[1.0, 2.0], [3.0, 4.0]])


class Prepared(NamedTuple):
    taps: np.ndarray
    gain: float


def prepare(params, dt):
    return Prepared(np.array([1.0, params.period, dt]), params.int)


def initial(params):
    return CounterState(params.period)


@controller(CounterParams(), CounterState(), prepare=prepare, initial=initial)
def prepared(p, s, command, feedback, t, dt):
    """Parameters worked out beforehand, a state that depends on them, a covariance written in place."""
    s.past[1, 0] = s.past[0, 1] + command * p.taps[1]
    s.past[0, 1] = 0.5 * s.past[1, 0]
    return s._replace(periods=s.periods + t), p.gain * (command - feedback) + s.past[1, 0] * dt + 1e-3 * s.periods


@controller(CounterParams(), CounterState())
def named(p, s, command, feedback):
    s.past[0, 0] = s.past[0, 0] * 0.5 + command
    return CounterState(s.periods + p.period * p.many, s.past), p.int * (command - feedback) + 1e-3 * s.periods


def loop_of(block, **more):
    parts = {"reference": zoo.sine(frequency=3.0), "controller": block, "plant": zoo.mass, "metrics": {}, **more}
    return Loop(**parts)


LOOPS = {
    "pid": loop_of(zoo.pid),
    "history": loop_of(zoo.history),
    "cascade": loop_of(zoo.cascade, plant=zoo.shown_mass),
    "observed": loop_of(zoo.observed),
    "two_axes": loop_of(zoo.two_pids, reference=zoo.circle, plant=zoo.table),
    "prepared": loop_of(prepared),
    "named": loop_of(named),
}


@pytest.fixture(autouse=True)
def compilers():
    for tool in ("gcc", "g++"):
        if shutil.which(tool) is None:
            missing(tool, f"{tool} is not installed")


def in_cpp(core: Core) -> str:
    """C++ that sets every knob."""
    n = core.name
    knobs = "".join(f"    m.params.{place} = m.params.{place};\n" for k in core.knobs for place in k.places)
    inputs = ", ".join("0" for _ in core.inputs)
    return (
        f'#include "{n}_machine.h"\n#include "{n}.h"\nint main()\n{{\n    {n}_machine m;\n    {n}_machine_init(&m);\n'
        f"{knobs}    {n}_machine_step(&m, 1, 0, {inputs});\n    return 0;\n}}\n"
    )


def written(core, folder):
    for name, text in {**core.files, "main.cpp": in_cpp(core)}.items():
        (folder / name).write_text(text, encoding="utf-8")
    return [folder / f"{core.name}.c", folder / f"{core.name}_machine.c"]


def player(core, folder):
    """C that plays rows through ``NAME_step``."""
    n, real, m = core.name, core.real, len(core.inputs)
    ins = ", ".join(f"({real})in[{m} * k + {i}]" for i in range(m))
    outs = len(core.outputs)
    call = f"y[0] = {n}_step(&params, &state, {ins});"
    if outs > 1:
        call = f"{n}_step(&params, &state, {ins}, {', '.join(f'&y[{i}]' for i in range(outs))});"
    file = folder / "player.c"
    file.write_text(
        f'#include "{n}.h"\nvoid play(const double *in, double *out, int64_t rows);\n'
        f"void play(const double *in, double *out, int64_t rows)\n{{\n    {n}_params params;\n    {n}_state state;\n"
        f"    {real} y[{outs}];\n    {n}_defaults(&params);\n    {n}_start(&params, &state);\n"
        f"    for (int64_t k = 0; k < rows; k++) {{\n        {call}\n"
        f"        for (int i = 0; i < {outs}; i++) {{\n            out[{outs} * k + i] = y[i];\n"
        "        }\n    }\n}\n"
    )
    return file


@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("name", LOOPS)
def test_an_exported_core_compiles_from_cpp_too_and_gives_the_bits_of_its_loop(name, real, tmp_path):
    core, record = export_controller(LOOPS[name], 0.3, name="axis", title="ours.*/??/", real=real)
    files = written(core, tmp_path)
    objects = [f.with_suffix(".o") for f in files]
    for file, made in zip(files, objects, strict=True):
        subprocess.run(["gcc", *printed.STRICT, "-c", "-o", str(made), str(file)], check=True)
    command = [*CPP, "-o", str(tmp_path / "main"), str(tmp_path / "main.cpp"), *map(str, objects), "-lm"]
    subprocess.run(command, check=True)
    assert subprocess.run([str(tmp_path / "main")], check=False).returncode == 0
    for level in ("-O0", "-O3"):
        play = printed.library([files[0], player(core, tmp_path)], level).play
        play.argtypes, play.restype = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64), None
        given = np.ascontiguousarray(record.inputs)
        out = np.zeros_like(record.outputs)
        play(given.ctypes.data, out.ctypes.data, len(given))
        assert printed.same(out, np.ascontiguousarray(record.outputs))
    assert len(np.unique(record.outputs[:, 0])) > 50


@pytest.mark.parametrize("name", nasty.STEPS)
def test_the_header_of_any_step_can_be_included_from_cpp(name, tmp_path):
    step, p, s, signals = nasty.STEPS[name]
    printed.written([printed.source_of(step, p, s, **signals)], tmp_path)
    main = tmp_path / "main.cpp"
    main.write_text('#include "axis.h"\nint main()\n{\n    axis_params p;\n    axis_defaults(&p);\n}\n')
    subprocess.run([*CPP, "-c", "-o", str(tmp_path / "main.o"), str(main)], check=True)


def test_the_names_of_our_own_fields_are_not_taken_by_a_parameter_or_state():
    core, _ = export_controller(LOOPS["named"], 0.1, name="axis", title="ours.named")
    assert {k.key: k.places for k in core.knobs}["period"] == ("period_",)
    assert "double period;" in core.files["axis.h"] and "double period_;" in core.files["axis.h"]


# ---- alignment
class Moved(NamedTuple):
    position: float
    velocity: float


def speed(command):
    return command.velocity


def align(command, feedback, output):
    return zoo.PIDState(output - speed(command), feedback)


def follows(s, command, feedback):
    return s._replace(integral=s.integral + command.position), s.integral - feedback


def test_alignment_gets_the_fields_that_only_it_reads_and_starts_the_state_that_it_says(tmp_path):
    block = make("controller", follows, None, zoo.PIDState(), align=align)
    source = printed.source_of(block, command=Moved(0.0, 0.0))
    assert [a.name for a in source.inputs] == ["command", "command_velocity", "feedback"]
    files = printed.written([source], tmp_path)
    more = tmp_path / "more.c"
    more.write_text(
        '#include "axis.h"\nvoid aligned(double *y);\nvoid aligned(double *y)\n{\n    axis_params p;\n'
        "    axis_state s;\n    axis_defaults(&p);\n    axis_start(&p, &s);\n"
        "    axis_align(&p, &s, 1.0, 0.25, 3.0, 7.0);\n"
        "    y[0] = s.integral;\n    y[1] = s.last_error;\n}\n"
    )
    out = (ctypes.c_double * 2)()
    printed.library([*files, more], "-O2").aligned(out)
    assert list(out) == [6.75, 3.0] == list(align(Moved(1.0, 0.25), 3.0, 7.0))


# ---- refusals


def clash(command):
    return command.a_x + command.a.x


class AX(NamedTuple):
    a: zoo.Two
    a_x: float


class Flat(NamedTuple):
    z: np.ndarray = np.array(3.0)


def flat(s, command):
    return s, command


def test_two_signals_of_one_name_and_arrays_of_no_dimension_are_refused():
    with pytest.raises(BlockError, match=r"'command.a.x' and 'command.a_x' would both be 'command_a_x' in C"):
        printed.source_of(clash, command=AX(zoo.Two(0.0, 0.0), 0.0))
    with pytest.raises(SubsetError, match="'z' is an array of no dimension"):
        printed.source_of(flat, None, Flat()).files()
