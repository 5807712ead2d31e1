"""An exported folder: written whole or not at all, checked before it appears."""

from __future__ import annotations

import hashlib
import json
import tempfile
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.export import c99
from leadscrew.export.core import Core, Record
from leadscrew.export.templates import render
from leadscrew.export.verdict import DIFFERENT, GOLDEN, IDENTICAL, NOT_RUN, Verdict, golden_text, read_golden
from leadscrew.figures.formats import integrated
from leadscrew.kernel import engines
from leadscrew.kernel.c99.names import is_identifier
from leadscrew.util import reading
from leadscrew.util.atomic import atomic_folder
from leadscrew.util.errors import DataError, EngineError, LeadscrewError, SubsetError, ValueRefused
from leadscrew.util.strict_json import strict

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

TARGETS = {
    "c99": "C99 sources, an example and a check program",
    "hal": "a LinuxCNC HAL component",
    "fmu2": "an FMI 2.0 co-simulation FMU",
    "fmu3": "an FMI 3.0 co-simulation FMU",
}
"""What a controller can be exported to."""

LIMITS = {
    "c99": ("max_output", "max_error", "max_wrong_way"),
    "hal": ("maxoutput", "max-following-error", "max-wrong-way"),
    "fmu": ("limits.max_output", "limits.max_error", "limits.max_wrong_way"),
}
"""What the limits of the machine layer are called there."""

BSD = """\
> Copyright (c) 2026, The Leadscrew authors
>
> Redistribution and use in source and binary forms, with or without modification, are permitted provided that the
> following conditions are met:
>
> 1. Redistributions of source code must retain the above copyright notice, this list of conditions and the following
>    disclaimer.
> 2. Redistributions in binary form must reproduce the above copyright notice, this list of conditions and the following
>    disclaimer in the documentation and/or other materials provided with the distribution.
> 3. Neither the name of the copyright holder nor the names of its contributors may be used to endorse or promote
>    products derived from this software without specific prior written permission.
>
> THIS SOFTWARE IS PROVIDED BY THE COPYRIGHT HOLDERS AND CONTRIBUTORS "AS IS" AND ANY EXPRESS OR IMPLIED WARRANTIES,
> INCLUDING, BUT NOT LIMITED TO, THE IMPLIED WARRANTIES OF MERCHANTABILITY AND FITNESS FOR A PARTICULAR PURPOSE ARE
> DISCLAIMED. IN NO EVENT SHALL THE COPYRIGHT HOLDER OR CONTRIBUTORS BE LIABLE FOR ANY DIRECT, INDIRECT, INCIDENTAL,
> SPECIAL, EXEMPLARY, OR CONSEQUENTIAL DAMAGES (INCLUDING, BUT NOT LIMITED TO, PROCUREMENT OF SUBSTITUTE GOODS OR
> SERVICES; LOSS OF USE, DATA, OR PROFITS; OR BUSINESS INTERRUPTION) HOWEVER CAUSED AND ON ANY THEORY OF LIABILITY,
> WHETHER IN CONTRACT, STRICT LIABILITY, OR TORT (INCLUDING NEGLIGENCE OR OTHERWISE) ARISING IN ANY WAY OUT OF THE USE
> OF THIS SOFTWARE, EVEN IF ADVISED OF THE POSSIBILITY OF SUCH DAMAGE.
"""


class ExportDiffers(LeadscrewError):
    """The exported C does not give the bits of the simulation: nothing is written."""


def write(
    core: Core, record: Record, target: str, folder: Path, *, loop: Loop | None = None, binary: bool = True
) -> dict[str, Any]:
    """Writes an export into a new folder and gives its manifest.

    With its ``loop``, a HAL export brings the rest of the loop as a simulated machine, to be tried on.
    ``binary=False`` leaves the shared library out of an FMU, which then needs no compiler here.

    Raises:
        ValueRefused: no such target.
        DataError: the folder exists, or cannot be written.
        EngineError: an FMU with its binary, and no C compiler.
        ExportDiffers: the compiled C gives other bits than the simulation.
    """
    if target not in TARGETS:
        raise ValueRefused(f"target = {target!r}: there are {', '.join(TARGETS)}")
    path = compiler_path()
    if target.startswith("fmu") and binary and path is None:
        raise EngineError(
            "an FMU needs a C compiler for its binary, and there is no gcc, clang or cc on the PATH; install gcc, or "
            "write one without: --sources-only"
        )
    golden = first_check(core, record) | {"sha256": fingerprint(np.column_stack([record.inputs, record.outputs]))}
    manifest = strict({**core.manifest, "target": target, "golden": golden})
    files = contents(core, record, target, path if binary else None, manifest, loop)
    with atomic_folder(folder) as beside:
        for name, content in files.items():
            if isinstance(content, bytes):
                (beside / name).write_bytes(content)
            else:
                (beside / name).write_text(content, encoding="utf-8", newline="\n")
    return dict(manifest)


def fingerprint(rows: np.ndarray) -> str:
    """Of the numbers of golden vectors, however they are written down; one NaN is as good as another."""
    return hashlib.sha256(np.where(np.isnan(rows), np.nan, rows).astype("<f8").tobytes()).hexdigest()


def compiler_path() -> str | None:
    """The C compiler of this machine, if there is one."""
    try:
        return engines.c_compiler()
    except EngineError:
        return None


def first_check(core: Core, record: Record) -> dict[str, Any]:
    """The exported C, compiled and replayed before anything is written.

    Raises:
        ExportDiffers: it gives other bits.
    """
    path = compiler_path()
    if path is None:
        return {"verdict": NOT_RUN, "cycles": len(record.outputs), "note": "there is no C compiler on this machine"}
    with tempfile.TemporaryDirectory(prefix="leadscrew-") as place:
        here = Path(place)
        for name, text in {**core.files, **c99.files(core), GOLDEN: golden_text(core, record)}.items():
            (here / name).write_text(text, encoding="utf-8", newline="\n")
        found = c99.replayed(here, core.name, path, "-O2", Path(path).name)
    if found.verdict != IDENTICAL:
        raise ExportDiffers(
            f"{core.title}: the exported C is not identical to the simulation ({found.verdict}, worst {found.worst}; "
            f"{found.note}); nothing was written; please report this with the controller's source"
        )
    return {"verdict": found.verdict, "cycles": found.cycles, "note": f"{found.note} -O2"}


def contents(
    core: Core, record: Record, target: str, path: str | None, manifest: dict[str, Any], loop: Loop | None = None
) -> dict[str, str | bytes]:
    """Every file of an export by name."""
    found: dict[str, str | bytes] = {GOLDEN: golden_text(core, record)}
    if target.startswith("fmu"):
        from leadscrew.export import fmu

        version = int(target[-1])
        found[f"{core.name}.fmu"] = fmu.build(core, version, path, record)
        about = fmu.readme(core, version)
    elif target == "hal":
        from leadscrew.export import hal

        found.update({**core.files, "check.c": c99.check_program(core), **hal.files(core)})
        if loop is not None:
            from leadscrew.export import plant

            try:
                found.update(plant.plant_files(loop, core))
            except SubsetError as error:
                loop, manifest["machine_left_out"] = None, str(error)
        about = hal.readme(core, machine=loop)
    else:
        found.update({**core.files, **c99.files(core)})
        about = c99.readme(core)
    found["README.md"] = render(
        "readme.md.j2", core=core, manifest=manifest, integrated=integrated(manifest["integration"]),
        target=TARGETS[target], about=about, licence=BSD, limits=LIMITS[target.rstrip("23")],
        fmu=target.startswith("fmu"),
    )  # fmt: skip
    found["manifest.json"] = json.dumps(manifest, indent=1, allow_nan=False) + "\n"
    return found


def read_manifest(folder: Path) -> dict[str, Any]:
    """The manifest of an exported folder.

    Raises:
        DataError: there is none, or it is not one of ours.
    """
    file = folder / "manifest.json"
    try:
        found = reading.json_object(file)
    except DataError as error:
        raise DataError(f"{folder} is not an exported folder: {error}") from None
    if not _ours(found):
        raise DataError(f"{file}: not a manifest that leadscrew export wrote; export the controller again")
    return dict(found)


def _ours(manifest: Any) -> bool:
    """Whether a manifest has all that the checks read."""
    try:
        ports = [*manifest["inputs"], *manifest["outputs"]]
        texts = [
            manifest["title"],
            manifest["golden"]["sha256"],
            *(p[k] for p in ports for k in ("name", "role", "unit")),
        ]
        sizes = [float(manifest["limits"]["max_output"]), float(manifest["period_s"])]
        return (
            manifest["schema_version"] == 1
            and manifest["target"] in TARGETS
            and is_identifier(manifest["name"])
            and manifest["real"] in ("double", "float")
            and manifest["sense"] in (1, -1)
            and len(manifest["outputs"]) > 0
            and all(isinstance(text, str) for text in texts)
            and sizes[0] >= 0.0 < sizes[1]
        )
    except (KeyError, TypeError, ValueError):
        return False


def verify(folder: Path) -> list[Verdict]:
    """Checks an exported folder with everything that this machine has.

    Raises:
        DataError: not an exported folder, or its golden vectors cannot be read.
    """
    manifest = read_manifest(folder)
    target = manifest["target"]
    found: list[Verdict] = []
    _, rows = read_golden(folder / GOLDEN)
    if fingerprint(rows) != manifest["golden"]["sha256"]:
        found.append(Verdict(GOLDEN, DIFFERENT, len(rows), note="not the golden vectors that were exported"))
    if not target.startswith("fmu"):
        found += c99.check(folder, manifest)
    if target != "c99":
        module = import_module(f"leadscrew.export.{target.rstrip('23')}_check")
        found += module.check(folder, manifest)
    return found
