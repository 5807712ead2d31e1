"""A small controller for the tests of the HAL target: a PD with velocity feedforward, written out by hand in C."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from leadscrew.export import hal
from leadscrew.export.core import Core, Knob, Limits, Port, Record
from leadscrew.export.machine import machine_files
from leadscrew.export.verdict import GOLDEN, golden_text

HEADER = """#ifndef @NAME@_H
#define @NAME@_H
#include <stdint.h>
typedef struct @name@_gains { real kp; real kd; } @name@_gains;
typedef struct @name@_params { real period; @name@_gains gains; int64_t mode; int on; } @name@_params;
typedef struct @name@_state { real last_error; real started; } @name@_state;
void @name@_defaults(@name@_params *params);
void @name@_start(const @name@_params *params, @name@_state *state);
real @name@_step(const @name@_params *params, @name@_state *state, real command, real command_velocity, real feedback);
#endif
"""
SOURCE = """#include "@name@.h"
void @name@_defaults(@name@_params *params)
{
    params->period = (real)0.001;
    params->gains.kp = (real)0.25;
    params->gains.kd = (real)0.004;
    params->mode = 1;
    params->on = 1;
}
void @name@_start(const @name@_params *params, @name@_state *state)
{
    (void)params;
    state->last_error = 0;
    state->started = 0;
}
real @name@_step(const @name@_params *params, @name@_state *state, real command, real command_velocity, real feedback)
{
    const real error = command - feedback;
    const real rate = state->started * (error - state->last_error) / params->period;
    state->last_error = error;
    state->started = 1;
    return @sign@(params->gains.kp * error + params->gains.kd * rate + (real)0.001 * command_velocity);
}
"""
MAX_OUTPUT = 0.3
"""Low enough for the recorded run to meet it."""


def core(name: str, sense: int = 1, real: str = "double", rediscretisable: bool = False) -> Core:
    """The controller under a name, as the exporter would give it."""
    made = Core(
        name=name,
        title=f"ours.{name}",
        doc='A PD with "feedforward", in µm or so.',
        real=real,
        period=0.001,
        inputs=(
            Port("command.position", "command", "command", "mm", "where to be"),
            Port("command.velocity", "command_velocity", "command-deriv", "mm/s", "how fast"),
            Port("feedback", "feedback", "feedback", "mm", "where it is"),
        ),
        outputs=(Port("output", "output", "output", "1", "duty"),),
        knobs=(
            Knob("kp", "kp", "float", 0.25, ("gains.kp",), "1/mm", "duty per millimetre", 0.0, np.inf, "(0, inf)"),
            Knob("gains.kd", "gains_kd", "float", 0.004, ("gains.kd",), "s/mm", "", 0.0, 1.0, "[0, 1]"),
            Knob("mode", "mode", "int", 1, ("mode",), "", "which way", 0, 3, "[0, 3]"),
            Knob("on", "on", "bool", True, ("on",)),
        ),
        baked=(),
        limits=Limits(MAX_OUTPUT, 100.0, 5.0),
        sense=sense,
        drive="duty",
        full_scale=1.0,
        bumpless=False,
        manifest={"rediscretisable": rediscretisable},
    )
    sign = "-" if sense < 0 else ""
    texts = {f"{name}.h": HEADER, f"{name}.c": SOURCE}
    texts = {
        k: t.replace("@NAME@", name.upper()).replace("@name@", name).replace("@sign@", sign) for k, t in texts.items()
    }
    texts = {k: t.replace("real ", f"{real} ").replace("(real)", f"({real})") for k, t in texts.items()}
    return replace(made, files={**texts, **machine_files(made)})


def record(made: Core, rows: int, period: float = 0.001) -> Record:
    """A recorded run of the controller on a drive with a lag, in the numbers of the core."""
    real = np.float32 if made.real == "float" else np.float64
    kp, kd, ff, dt = real(0.25), real(0.004), real(0.001), real(period)
    x = v = 0.0
    last = started = real(0)
    inputs, outputs = [], []
    for k in range(rows):
        command, velocity = real(4.0 * (1 - np.cos(0.006 * k))), real(24.0 * np.sin(0.006 * k))
        feedback = real(x)
        error = command - feedback
        output = kp * error + kd * (started * (error - last) / dt) + ff * velocity
        last, started = error, real(1)
        inputs.append((float(command), float(velocity), float(feedback)))
        outputs.append((float(output) * made.sense,))
        v += (min(max(float(output), -MAX_OUTPUT), MAX_OUTPUT) * 289.0 - v) * 0.001 / 0.02
        x += v * 0.001
    return Record(np.array(inputs), np.array(outputs))


def manifest(made: Core) -> dict:
    """What the exporter writes to ``manifest.json``, as far as the HAL target reads it."""
    ports = {
        k: [{"key": p.key, "name": p.name, "role": p.role, "unit": p.unit} for p in getattr(made, k)]
        for k in ("inputs", "outputs")
    }
    limits = {k: getattr(made.limits, k) for k in ("max_output", "max_error", "max_wrong_way")}
    return {
        "name": made.name,
        "real": made.real,
        "period_s": made.period,
        "sense": made.sense,
        **ports,
        "limits": limits,
    }


def export(made: Core, folder: Path, rows: int = 3000) -> Path:
    """An exported folder with golden vectors."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in {**made.files, **hal.files(made), GOLDEN: golden_text(made, record(made, rows))}.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder
