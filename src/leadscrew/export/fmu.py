"""A controller as a functional mock-up unit: FMI 2.0 or 3.0 co-simulation, sources and binary in one archive."""

from __future__ import annotations

import hashlib
import io
import math
import platform
import subprocess
import tempfile
import zipfile
from pathlib import Path

from leadscrew import escape
from leadscrew.export.core import Core, Record
from leadscrew.export.fmu_variables import Variable, variables
from leadscrew.export.fmu_xml import build_description, model_description
from leadscrew.export.machine import LICENCE, number
from leadscrew.export.templates import render
from leadscrew.export.verdict import GOLDEN, golden_text
from leadscrew.kernel.errors import LeadscrewError, ValueRefused

VERSIONS = (2, 3)
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden")
WARNINGS = ("-Wall", "-Wextra", "-pedantic", "-Werror")
_FOLDERS = {2: "linux64", 3: "x86_64-linux"}
_HEADERS = Path(__file__).parent / "fmi"


def build(core: Core, version: int, compiler: str | None, record: Record | None = None) -> bytes:
    """The ``.fmu`` archive; the same core gives the same bytes.

    Raises:
        ValueRefused: another FMI version, or a parameter that FMI cannot hold.
        LeadscrewError: the compiler is missing or refused the sources, or this is not x86-64 Linux.
    """
    if version not in VERSIONS:
        raise ValueRefused(f"FMI version {version!r}: allowed are 2 and 3")
    text, compiled = _description(core, version)
    files: dict[str, str | bytes] = {"modelDescription.xml": text}
    files |= {f"sources/{name}": source for name, source in compiled.items()}
    if version == 3:
        files["sources/buildDescription.xml"] = build_description(core, _c_files(compiled))
    if compiler is not None:
        files[f"binaries/{_FOLDERS[version]}/{core.name}.so"] = _binary(core, compiled, compiler)
    about = readme(core, version)
    files["documentation/README.md"] = about
    files["documentation/index.html"] = _page(core, about)
    files["documentation/licenses/fmi.txt"] = (_HEADERS / "LICENSE.txt").read_text(encoding="utf-8")
    if record is not None:
        files[f"resources/{GOLDEN}"] = golden_text(core, record)
    return _archive(files)


def readme(core: Core, version: int) -> str:
    """What stands about the unit in the README of the export."""
    return render("fmu_readme.md.j2", core=core, version=version, period=repr(core.period), variables=variables(core))


def _description(core: Core, version: int) -> tuple[str, dict[str, str]]:
    """``modelDescription.xml`` and the sources, both carrying one token that is made of all they say."""
    shown = variables(core)
    blank = sources(core, version, shown, "")
    names = _c_files(blank)
    said = [model_description(core, shown, version, "", names), *(f"{k}\n{v}" for k, v in sorted(blank.items()))]
    x = hashlib.sha256("\n".join(said).encode()).hexdigest()
    token = f"{{{x[:8]}-{x[8:12]}-{x[12:16]}-{x[16:20]}-{x[20:32]}}}"
    return model_description(core, shown, version, token, names), sources(core, version, shown, token)


def sources(core: Core, version: int, shown: tuple[Variable, ...], token: str) -> dict[str, str]:
    """All C files of a unit by name."""

    def bound(value: float) -> str:
        return repr(float(value)) if math.isfinite(value) else "-DBL_MAX" if value < 0 else "DBL_MAX"

    # FMI 2 sets a choice as an Integer, FMI 3 as an Int64
    whole = ("int", "choice") if version == 2 else ("int",)
    kinds = [("real", ("real",), "double", "real number"), ("int", whole, "int", "whole number"),
             ("bool", ("bool",), "int", "Boolean")]  # fmt: skip
    if version == 3 and any(v.kind == "choice" for v in shown):
        kinds.append(("choice", ("choice",), "long long", "choice"))
    names = {
        "core": core,
        "kinds": kinds,
        "n": core.name,
        "licence": LICENCE,
        "token": token,
        "period": repr(core.period),
        "variables": shown,
        "bound": bound,
        "infinite": math.inf,
        "number": lambda x: number(x, "double"),
    }
    files = dict(core.files)
    for end in ("h", "c"):
        files[f"{core.name}_fmu.{end}"] = render(f"fmu.{end}.j2", **names)
    files[f"{core.name}_fmi{version}.c"] = render(f"fmi{version}.c.j2", **names)
    for header in sorted(_HEADERS.glob(f"fmi{version}*.h")):
        files[header.name] = header.read_text(encoding="utf-8")
    return files


def _c_files(files: dict[str, str]) -> list[str]:
    return sorted(name for name in files if name.endswith(".c"))


def _binary(core: Core, files: dict[str, str], compiler: str) -> bytes:
    if platform.system() != "Linux" or platform.machine() != "x86_64":
        raise LeadscrewError(
            f"no FMU binary for {platform.system()} {platform.machine()}: only x86-64 Linux is built; "
            "export without a compiler, and compile the sources in the FMU with the importer"
        )
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        out = f"{core.name}.so"
        command = [compiler, *FLAGS, *WARNINGS, "-s", "-Wl,--no-undefined", "-o", out, *_c_files(files), "-lm"]
        try:
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        except OSError as error:
            raise LeadscrewError(f"the C compiler {compiler} does not start: {error.strerror or error}") from None
        if done.returncode:
            first = next((x for x in done.stderr.splitlines() if "error" in x), done.stderr.strip())
            raise LeadscrewError(f"{compiler} refuses the sources of the FMU {core.name}: {first}")
        return (Path(folder) / out).read_bytes()


def _page(core: Core, about: str) -> str:
    title = escape.html(core.title)
    return f'<!doctype html>\n<meta charset="utf-8">\n<title>{title}</title>\n<pre>\n{escape.html(about)}</pre>\n'


def _archive(files: dict[str, str | bytes]) -> bytes:
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = (0o755 if name.endswith(".so") else 0o644) << 16
            archive.writestr(entry, content)
    return whole.getvalue()
