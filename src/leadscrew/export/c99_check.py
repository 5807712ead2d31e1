"""Compiles exported C with whatever compilers the machine has and replays the golden vectors."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from leadscrew.export.c99 import FLAGS
from leadscrew.export.verdict import DIFFERENT, FAILED, GOLDEN, IDENTICAL, NOT_RUN, Verdict

COMPILERS = ("gcc", "clang")
LEVELS = ("-O0", "-O2", "-O3")
LONGEST_S = 600
_SAID = re.compile(r"cycles (\d+) different (\d+) worst (\S+)")


def check(folder: Path, manifest: dict[str, Any]) -> list[Verdict]:
    """One verdict for every compiler and level of optimisation."""
    found: list[Verdict] = []
    for compiler in COMPILERS:
        path = shutil.which(compiler)
        if path is None:
            found.append(Verdict(f"c99 {compiler}", NOT_RUN, note=f"{compiler} is not on this machine"))
            continue
        version = subprocess.run([path, "-dumpversion"], capture_output=True, text=True, check=False).stdout.strip()
        for level in LEVELS:
            found.append(replayed(folder, manifest["name"], path, level, f"{compiler} {version}"))
    return found


def replayed(folder: Path, name: str, compiler: str, level: str, note: str) -> Verdict:
    """The verdict on one build."""
    target = f"c99 {Path(compiler).name} {level}"
    with tempfile.TemporaryDirectory(prefix="leadscrew-") as place:
        program = Path(place) / "check"
        sources = [str(folder / "check.c"), str(folder / f"{name}.c")]
        machine = ["-c", "-o", str(Path(place) / "machine.o"), str(folder / f"{name}_machine.c")]
        for command in ([*sources, "-o", str(program), "-lm"], machine):
            built = subprocess.run([compiler, *FLAGS, level, *command], capture_output=True, text=True, check=False)
            if built.returncode:
                said = next((x for x in built.stderr.splitlines() if "error" in x), built.stderr.strip()[:200])
                return Verdict(target, FAILED, note=f"does not compile: {said}")
        command = [str(program), str(folder / GOLDEN)]
        try:
            ran = subprocess.run(command, capture_output=True, text=True, check=False, timeout=LONGEST_S)
        except subprocess.TimeoutExpired:
            return Verdict(target, FAILED, note=f"check did not end within {LONGEST_S} s")
        found = _SAID.search(ran.stdout)
        if found is None:
            return Verdict(target, FAILED, note=ran.stderr.strip()[:200] or f"check ended with {ran.returncode}")
        cycles, different, worst = int(found[1]), int(found[2]), float(found[3])
        same = ran.returncode == 0 and different == 0 and cycles == golden_cycles(folder)
        return Verdict(target, IDENTICAL if same else DIFFERENT, cycles, worst, note)


def golden_cycles(folder: Path) -> int:
    """How many rows the golden vectors have."""
    with (folder / GOLDEN).open(encoding="utf-8") as lines:
        return sum(1 for _ in lines) - 1
