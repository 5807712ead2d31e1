"""Plays golden inputs into an FMU through somebody else's importer; a process of its own, as importers can crash.

``python -m leadscrew.export.fmu_play FOLDER`` reads ``job.json`` and ``rows.npy`` there, and writes ``outputs.npy`` and
``said.json``.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np


class Missing(Exception):
    """Something that the importer needs is not on this machine."""


def fmpy_rows(job: dict[str, Any], rows: np.ndarray) -> tuple[np.ndarray, dict[str, Any]]:
    """FMPy, call by call; with ``compile`` in the job from a binary that it makes of the sources."""
    import fmpy
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Slave
    from fmpy.validation import validate_fmu

    problems = validate_fmu(job["fmu"])
    about = fmpy.read_model_description(job["fmu"])
    reference = {v.name: v.valueReference for v in about.modelVariables}
    second = about.fmiVersion == "2.0"
    with tempfile.TemporaryDirectory() as folder:
        fmpy.extract(job["fmu"], folder)
        if job["compile"]:
            _compile(Path(folder))
        unit = (FMU2Slave if second else FMU3Slave)(
            guid=about.guid,
            unzipDirectory=folder,
            modelIdentifier=about.coSimulation.modelIdentifier,
            instanceName="unit",
        )
        unit.instantiate()
        if second:
            unit.setupExperiment(startTime=0.0)
        unit.enterInitializationMode()
        if "bumpless" in reference:
            unit.setBoolean([reference["bumpless"]], [False])
        unit.exitInitializationMode()
        put, get = (unit.setReal, unit.getReal) if second else (unit.setFloat64, unit.getFloat64)
        ins, outs = ([reference[name] for name in job[side]] for side in ("inputs", "outputs"))
        got = []
        for k, row in enumerate(rows.tolist()):
            put(ins, row)
            unit.doStep(k * job["period"], job["period"])
            got.append(list(get(outs)))
        fault = (unit.getInteger if second else unit.getInt32)([reference["fault_code"]])[0]
        unit.terminate()
        unit.freeInstance()
    return np.array(got), {"problems": problems, "fault": fault}


def _compile(folder: Path) -> None:
    from fmpy.build import build_platform_binary

    os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    for tool in ("cmake", "cc"):
        if not shutil.which(tool):
            raise Missing(f"{tool} is not installed")
    shutil.rmtree(folder / "binaries", ignore_errors=True)
    build_platform_binary(folder, cmake_options={"CMAKE_C_FLAGS:STRING": "-ffp-contract=off"})


def ecos_rows(job: dict[str, Any], rows: np.ndarray) -> tuple[np.ndarray, dict[str, Any]]:
    """The C++ co-simulation engine ecos, with the inputs set before every step."""
    try:
        import ecospy
    except OSError as error:
        raise Missing(f"ecospy does not load (on Debian it needs libtbb12): {error}") from None

    with ecospy.EcosSimulationStructure() as structure:
        structure.add_model("unit", job["fmu"])
        with ecospy.EcosSimulation(structure=structure, step_size=job["period"]) as run:
            if not run.init():
                raise RuntimeError(f"ecos does not initialise the unit: {ecospy.EcosLib.get_last_error()}")
            if job["bumpless"]:
                run.set_bool("unit::bumpless", False)
            got = []
            for row in rows.tolist():
                for name, value in zip(job["inputs"], row, strict=True):
                    run.set_real(f"unit::{name}", value)
                run.step()
                got.append([run.get_real(f"unit::{name}") for name in job["outputs"]])
            fault = run.get_integer("unit::fault_code")
            run.terminate()
    return np.array(got), {"problems": [], "fault": fault}


IMPORTERS = {"fmpy": fmpy_rows, "ecospy": ecos_rows}


def main(folder: Path) -> None:
    """Does the job that lies in a folder."""
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    try:
        got, said = IMPORTERS[job["importer"]](job, np.load(folder / "rows.npy"))
        np.save(folder / "outputs.npy", got)
    except Missing as error:
        said = {"missing": str(error)}
    (folder / "said.json").write_text(json.dumps(said), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
