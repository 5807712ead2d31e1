"""Checks an exported FMU with two importers of other people, bit for bit against the golden vectors."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import json
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from leadscrew.export.core import expected_outputs
from leadscrew.export.verdict import FAILED, GOLDEN, NOT_RUN, Verdict, compared, read_golden
from leadscrew.util.system import safe_path

_ROWS = (("FMPy", "fmpy", False), ("FMPy, compiled from its own sources", "fmpy", True), ("ecos", "ecospy", False))
_BINARIES = ("binaries/linux64/", "binaries/x86_64-linux/")
_LONGEST = 600.0


def check(folder: Path, manifest: dict[str, Any]) -> list[Verdict]:
    """One verdict for each importer, and one for the binary that FMPy makes of the sources.

    Raises:
        DataError: the golden vectors cannot be read.
    """
    file = folder / f"{manifest['name']}.fmu"
    try:
        with zipfile.ZipFile(file) as archive:
            version = ET.fromstring(archive.read("modelDescription.xml")).get("fmiVersion", "?")
            binary = any(name.startswith(_BINARIES) for name in archive.namelist())
    except (OSError, KeyError, zipfile.BadZipFile, ET.ParseError) as error:
        return [Verdict("fmu", FAILED, note=f"{file} is not an FMU: {error}")]
    _, rows = read_golden(folder / GOLDEN)
    found = []
    for label, importer, compiles in _ROWS:
        target = f"fmu{version[:1]} {label}"
        if not binary and not compiles:
            found.append(Verdict(target, NOT_RUN, note="the FMU holds sources only"))
        elif importlib.util.find_spec(importer) is None:
            note = f"{importer} is not installed: pip install leadscrew[verify]"
            found.append(Verdict(target, NOT_RUN, note=note))
        else:
            found.append(_played(target, importer, compiles, file, manifest, rows))
    return found


def _played(
    target: str, importer: str, compiles: bool, file: Path, manifest: dict[str, Any], rows: np.ndarray
) -> Verdict:
    """Runs one importer in a process of its own and judges what came back."""
    inputs, outputs = ([p["name"] for p in manifest[side]] for side in ("inputs", "outputs"))
    job = {"importer": importer, "compile": compiles, "fmu": str(file.resolve()), "inputs": inputs, "outputs": outputs,
           "bumpless": manifest.get("bumpless", False)}  # fmt: skip
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "job.json").write_text(json.dumps({**job, "period": manifest["period_s"]}), encoding="utf-8")
        np.save(folder / "rows.npy", rows[:, : len(inputs)])
        command = [sys.executable, *safe_path(), "-m", "leadscrew.export.fmu_play", name]
        try:
            done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=_LONGEST)
        except subprocess.TimeoutExpired:
            return Verdict(target, FAILED, note=f"{importer} did not end within {_LONGEST:g} s")
        if done.returncode:
            return Verdict(target, FAILED, note=_why(importer, done))
        said = json.loads((folder / "said.json").read_text(encoding="utf-8"))
        if "missing" in said:
            return Verdict(target, NOT_RUN, note=said["missing"])
        got = np.load(folder / "outputs.npy")
    note = f"{importer} {importlib.metadata.version(importer)}"
    if said["problems"]:
        return Verdict(target, FAILED, len(got), note=f"{note}: {said['problems'][0]}")
    if said["fault"]:
        note += f"; fault_code {said['fault']} at the end"
    return compared(target, expected_outputs(manifest, rows[:, len(inputs) :]), got, note)


def _why(importer: str, done: subprocess.CompletedProcess[str]) -> str:
    """The last thing that a failed importer said, with the unit's own message where there is one."""
    lines = [x.strip() for x in f"{done.stdout}\n{done.stderr}".splitlines() if x.strip()]
    own = [x for x in lines if x.startswith("[ERROR]")]
    end = f"signal {-done.returncode}" if done.returncode < 0 else lines[-1] if lines else f"status {done.returncode}"
    return f"{importer}: {'; '.join([*own[-1:], end])}"
