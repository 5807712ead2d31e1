"""A small controller, its recorded run, and a handle on its FMU for the tests of the FMU targets."""

import contextlib
import dataclasses
import shutil
import tempfile
import zipfile
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from leadscrew.export import fmu
from leadscrew.export.core import Core, Knob, Limits, Port, Record
from leadscrew.export.machine import machine_files
from leadscrew.export.verdict import GOLDEN, golden_text
from tests.tools import missing

PERIOD = 0.001
_HEADER = """#ifndef SAMPLE_H
#define SAMPLE_H
#include <stdint.h>
typedef struct sample_gains { REAL kp; REAL kd; } sample_gains;
typedef struct sample_params { REAL period; sample_gains gains; REAL kp_again; REAL tau; int64_t mode; int64_t quiet; }
    sample_params;
typedef struct sample_state { REAL last_error; REAL started; } sample_state;
void sample_defaults(sample_params *p);
void sample_start(const sample_params *p, sample_state *s);
REAL sample_step(const sample_params *p, sample_state *s, REAL command, REAL command_velocity, REAL feedback);
#endif
"""
_SOURCE = """#include "sample.h"
void sample_defaults(sample_params *p)
{
    p->period = PERIOD; p->gains.kp = KP; p->gains.kd = KD; p->kp_again = KP; p->tau = TAU; p->mode = 1; p->quiet = 0;
}
void sample_start(const sample_params *p, sample_state *s) { (void)p; s->last_error = 0; s->started = 0; }
REAL sample_step(const sample_params *p, sample_state *s, REAL command, REAL command_velocity, REAL feedback)
{
    const REAL error = command - feedback;
    const REAL rate = s->started * (error - s->last_error) / p->period;
    const REAL sum = p->gains.kp * error + p->gains.kd * rate + PER_SPEED * command_velocity / p->tau;
    s->last_error = error;
    s->started = 1;
    return p->quiet || p->mode == 0 ? 0 : p->kp_again == p->gains.kp ? -sum : sum;
}
"""
_NUMBERS = {"KP": 0.25, "KD": 0.004, "TAU": 0.3, "PER_SPEED": 0.0003, "PERIOD": PERIOD}


def core(real: str = "double", **changes) -> Core:
    """A PD controller of the opposite sign, with a knob of every kind; ``changes`` are other numbers in the C code."""
    source = _SOURCE
    for name, value in sorted({**_NUMBERS, **changes}.items(), key=lambda x: -len(x[0])):
        source = source.replace(name, f"{value!r}{'f' if real == 'float' else ''}")
    made = Core(
        name="sample",
        title="ours.sample",
        doc="A PD controller: <b> & 'quotes'.",
        real=real,
        period=PERIOD,
        inputs=(
            Port("command", "command", "command", "mm", "where to be"),
            Port("command.velocity", "command_velocity", "command-deriv", "mm/s", "how fast"),
            Port("feedback", "feedback", "feedback", "mm", "where it is"),
        ),
        outputs=(Port("output", "output", "output", "V", "to the drive"),),
        knobs=(
            Knob(
                "kp", "kp", "float", 0.25, ("gains.kp", "kp_again"), "V/mm", "gain | of error", 0.0, np.inf, "[0, inf)"
            ),
            Knob("gains.kd", "gains_kd", "float", 0.004, ("gains.kd",), "V s/mm", "", 0.0, 0.1, "[0, 0.1]"),
            Knob("tau.0", "tau", "float", 0.3, ("tau",), "s", "", 0.0, 1.0, "(0, 1)"),
            Knob("mode", "mode", "int", 1, ("mode",), "", "which way", 0, 3, "[0, 3]"),
            Knob("enable", "quiet", "bool", False, ("quiet",), "", "no output", 0, 1, ""),
        ),
        baked=(),
        limits=Limits(0.75, 100.0, 5.0),
        sense=-1,
        drive="voltage",
        full_scale=10.0,
        bumpless=False,
    )
    header = _HEADER.replace("REAL", real)
    return dataclasses.replace(
        made, files={"sample.h": header, "sample.c": source.replace("REAL", real), **machine_files(made)}
    )


def record(rows: int = 3000, real: str = "double") -> Record:
    """A run of it on a first-order axis; calculated in the precision of the controller."""
    f = np.float32 if real == "float" else np.float64
    kp, kd, tau, per_speed, period = (f(_NUMBERS[n]) for n in ("KP", "KD", "TAU", "PER_SPEED", "PERIOD"))
    x = v = 0.0
    last, started = f(0), f(0)
    inputs, outputs = [], []
    for k in range(rows):
        command, speed, feedback = f(10.0 * (1.0 - np.cos(6.0 * k * PERIOD))), f(60.0 * np.sin(6.0 * k * PERIOD)), f(x)
        error = command - feedback
        rate = started * (error - last) / period
        output = -(kp * error + kd * rate + per_speed * speed / tau)
        last, started = error, f(1)
        inputs.append((command, speed, feedback))
        outputs.append((output,))
        v += (-float(output) * 60.0 - v) * PERIOD / 0.02
        x += v * PERIOD
    return Record(np.array(inputs, dtype=np.float64), np.array(outputs, dtype=np.float64))


def manifest(of: Core) -> dict:
    """What ``manifest.json`` says of it."""
    ports = {side: [dataclasses.asdict(p) for p in getattr(of, side)] for side in ("inputs", "outputs")}
    limits = dataclasses.asdict(of.limits)
    return {"name": of.name, "real": of.real, "period_s": of.period, "sense": of.sense, "limits": limits, **ports}


def exported(folder: Path, of: Core, version: int, run: Record, compiler: str | None = "gcc") -> Path:
    """An exported folder with the FMU and the golden vectors."""
    if not shutil.which("gcc"):
        missing("gcc", "gcc is not installed")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{of.name}.fmu").write_bytes(fmu.build(of, version, compiler, run))
    (folder / GOLDEN).write_text(golden_text(of, run))
    return folder


class Unit:
    """One instance of an FMU in FMPy, by the names of its variables."""

    def __init__(self, folder: Path, version: int) -> None:
        from fmpy.fmi2 import FMU2Slave
        from fmpy.fmi3 import FMU3Slave

        about = ET.parse(folder / "modelDescription.xml").getroot()
        self.second = version == 2
        tags = about.findall("ModelVariables/ScalarVariable") if self.second else about.findall("ModelVariables/*")
        self.tags = {x.get("name"): x for x in tags}
        self.kinds = {name: x[0].tag if self.second else x.tag for name, x in self.tags.items()}
        self.fmi = (FMU2Slave if self.second else FMU3Slave)(
            guid=about.get("guid") or about.get("instantiationToken"),
            unzipDirectory=str(folder),
            modelIdentifier=about.find("CoSimulation").get("modelIdentifier"),
            instanceName="unit",
        )
        self.fmi.instantiate()

    def begin(self, **parameters) -> "Unit":
        """Initialises with parameters set in initialisation mode."""
        if self.second:
            self.fmi.setupExperiment(startTime=0.0)
        self.fmi.enterInitializationMode()
        for name, value in parameters.items():
            self.set(name.replace("__", "."), value)
        self.fmi.exitInitializationMode()
        self.time = 0.0
        return self

    def set(self, name: str, value) -> None:
        getattr(self.fmi, f"set{self.kinds[name]}")([int(self.tags[name].get("valueReference"))], [value])

    def get(self, name: str):
        return getattr(self.fmi, f"get{self.kinds[name]}")([int(self.tags[name].get("valueReference"))])[0]

    def step(self, periods: float = 1) -> None:
        self.fmi.doStep(self.time, periods * PERIOD)
        self.time += periods * PERIOD

    def play(self, rows: np.ndarray) -> np.ndarray:
        """Steps through rows of inputs and gives the outputs."""
        got = []
        for row in rows.tolist():
            for name, value in zip(("command", "command_velocity", "feedback"), row, strict=True):
                self.set(name, value)
            self.step()
            got.append([self.get("output")])
        return np.array(got)


@contextlib.contextmanager
def unpacked(archive: bytes):
    """The folder of an FMU's files."""
    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "unit.fmu"
        file.write_bytes(archive)
        with zipfile.ZipFile(file) as z:
            z.extractall(Path(name) / "unit")
        yield Path(name) / "unit"
