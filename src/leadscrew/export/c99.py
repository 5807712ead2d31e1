"""The target ``c99``: sources, an example, and a program that checks them by the golden vectors.

:func:`check` compiles them with whatever compilers the machine has and replays the golden vectors.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from leadscrew.export.core import Core, Port
from leadscrew.export.machine import LICENCE, number
from leadscrew.export.templates import render
from leadscrew.export.verdict import DIFFERENT, FAILED, GOLDEN, IDENTICAL, NOT_RUN, Verdict
from leadscrew.util.escape import c_format

FLAGS = ("-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-ffp-contract=off")
"""How every exported C file must compile. Contraction off: a fused multiply-add would change the results."""


def shown_unit(port: Port) -> str:
    """A unit behind a number in a format string of C; nothing for a pure number."""
    return f" {c_format(port.unit)}" if port.unit not in ("", "1") else ""


def check_program(core: Core) -> str:
    """``check.c``."""
    return render(
        "c99_check.c.j2", n=core.name, real=core.real, inputs=core.inputs, outputs=core.outputs, licence=LICENCE,
        cast="(float)" if core.real == "float" else "", unit=shown_unit(core.outputs[0]),
    )  # fmt: skip


def files(core: Core) -> dict[str, str]:
    """The files of the target, besides the core's own."""
    example = core.knobs[0].places[0] if core.knobs else "period"
    main = render(
        "c99_main.c.j2", n=core.name, core=core, real=core.real, period=repr(core.period), example=example,
        unit=shown_unit(core.outputs[0]), way=shown_unit(core.inputs[0]), number=lambda x: number(x, core.real),
    )  # fmt: skip
    return {"check.c": check_program(core), "main.c": main}


def readme(core: Core) -> str:
    """The part of the README that is about C."""
    n = core.name
    start = f"""
`{n}_machine_init` sets `m.bumpless = 1`: when enabled, the controller goes on from an output of zero. With
`m.bumpless = 0` it starts from its start state, as in the simulation and in `golden.csv`.
"""
    return f"""\
## Calling it from C

```c
#include "{n}_machine.h"

{n}_machine m;
{n}_machine_init(&m);            /* once */
{n}_machine_step(&m, enable, 0, {", ".join(i.name for i in core.inputs)});   /* every {core.period!r} s */
use(m.{core.outputs[0].name});
```
{start if core.bumpless else ""}
`{n}_step()` in `{n}.h` is the controller alone, in its own signs, without limits and faults.
Numbers are `{core.real}`. No memory is allocated and there are no globals: every instance has its own struct.

Compile with `{" ".join(FLAGS[:1])} {FLAGS[-1]}` (contraction off, or results may change), and never with
`-ffast-math`. The only library functions used are in `math.h` (`-lm`), all of them exact.

    cc {" ".join(FLAGS)} -O2 -o check check.c {n}.c -lm && ./check
    cc {" ".join(FLAGS)} -O2 -o example main.c {n}.c {n}_machine.c -lm && ./example

`check` replays `golden.csv` and exits with 0 only if every output is identical.
"""


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
