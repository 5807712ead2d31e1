"""A controller as a functional mock-up unit: FMI 2.0 or 3.0 co-simulation, sources and binary in one archive.

In the order of the file: units as FMI wants them (exponents of the SI base units and a factor), the variables that an
importer sees, ``modelDescription.xml`` and ``buildDescription.xml``, the archive.
"""

from __future__ import annotations

import hashlib
import io
import math
import platform
import re
import subprocess
import tempfile
import zipfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from leadscrew.export.core import Core, Knob, Port, Record
from leadscrew.export.machine import LICENCE, number
from leadscrew.export.templates import render
from leadscrew.export.verdict import GOLDEN, golden_text
from leadscrew.util import escape
from leadscrew.util.errors import LeadscrewError, ValueRefused
from leadscrew.util.escape import one_line, visible

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


def _unit(factor: Fraction | int = 1, **exponents: int) -> tuple[Fraction, dict[str, int]]:
    return Fraction(factor), exponents


_TURN = Fraction(math.pi)
_KNOWN = {
    "1": _unit(),
    "%": _unit(Fraction(1, 100)),
    "m": _unit(m=1),
    "g": _unit(Fraction(1, 1000), kg=1),
    "s": _unit(s=1),
    "min": _unit(60, s=1),
    "h": _unit(3600, s=1),
    "A": _unit(A=1),
    "K": _unit(K=1),
    "mol": _unit(mol=1),
    "cd": _unit(cd=1),
    "rad": _unit(rad=1),
    "deg": _unit(_TURN / 180, rad=1),
    "rev": _unit(2 * _TURN, rad=1),
    "rpm": _unit(_TURN / 30, rad=1, s=-1),
    "Hz": _unit(s=-1),
    "N": _unit(kg=1, m=1, s=-2),
    "Nm": _unit(kg=1, m=2, s=-2),
    "J": _unit(kg=1, m=2, s=-2),
    "W": _unit(kg=1, m=2, s=-3),
    "V": _unit(kg=1, m=2, s=-3, A=-1),
    "C": _unit(A=1, s=1),
    "ohm": _unit(kg=1, m=2, s=-3, A=-2),
    "H": _unit(kg=1, m=2, s=-2, A=-2),
    "F": _unit(kg=-1, m=-2, s=4, A=2),
    "T": _unit(kg=1, s=-2, A=-1),
    "Pa": _unit(kg=1, m=-1, s=-2),
}
_PREFIXES = {"G": 9, "M": 6, "k": 3, "c": -2, "m": -3, "u": -6, "µ": -6, "μ": -6, "n": -9}
_TOKENS = re.compile(r"\s*(/|\*|\(|\)|\^-?\d+|[A-Za-zµμ%]+|1)\s*")


def base_units(text: str) -> tuple[float, dict[str, int]] | None:
    """Factor and exponents of a unit such as ``V/(mm s)``; ``None`` where it is not made of known units."""
    tokens, at = [], 0
    while at < len(text):
        found = _TOKENS.match(text, at)
        if not found:
            return None
        tokens.append(found[1])
        at = found.end()
    try:
        factor, exponents = _product(tokens)
    except (LookupError, ValueError):
        return None
    return (float(factor), exponents) if not tokens else None


def _product(tokens: list[str]) -> tuple[Fraction, dict[str, int]]:
    """Takes factors, left to right, up to the end or a closing bracket."""
    factor, exponents = _power(tokens)
    while tokens and tokens[0] != ")":
        sign = -1 if tokens[0] == "/" else 1
        if tokens[0] in "/*":
            tokens.pop(0)
        more, of = _power(tokens)
        factor *= more**sign
        exponents = {b: exponents.get(b, 0) + sign * of.get(b, 0) for b in BASE}
    return factor, {b: n for b, n in exponents.items() if n}


def _power(tokens: list[str]) -> tuple[Fraction, dict[str, int]]:
    """Takes one unit or bracket, with its exponent."""
    first = tokens.pop(0)
    if first == "(":
        factor, exponents = _product(tokens)
        if tokens.pop(0) != ")":
            raise ValueError("a bracket is not closed")
    else:
        factor, exponents = _named(first)
    if tokens and tokens[0].startswith("^"):
        power = int(tokens.pop(0)[1:])
        factor, exponents = factor**power, {b: n * power for b, n in exponents.items()}
    return factor, exponents


def _named(name: str) -> tuple[Fraction, dict[str, int]]:
    if name in _KNOWN:
        return _KNOWN[name]
    factor, exponents = _KNOWN[name[1:]]
    return factor * Fraction(10) ** _PREFIXES[name[0]], exponents


_INTEGER = 2**31 - 1
_PLAIN = re.compile(r"[A-Za-z_]\w*", re.ASCII)


@dataclass(frozen=True)
class Variable:
    """One variable, with where it lies in C below ``v->``."""

    reference: int
    name: str
    kind: str
    """``real``, ``int``, ``bool`` or ``choice``."""
    causality: str
    """``input``, ``output`` or ``parameter``."""
    places: tuple[str, ...]
    start: float | int | bool | None = None
    unit: str = ""
    doc: str = ""
    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False
    open_high: bool = False
    names: tuple[str, ...] = ()
    """Of a choice, from 0."""

    @property
    def range(self) -> str:
        """The allowed range in interval notation; of a choice its numbers and names."""
        if self.names:
            return ", ".join(f"{i} {name}" for i, name in enumerate(self.names))
        left = "(" if self.open_low or self.low == -math.inf else "["
        right = ")" if self.open_high or self.high == math.inf else "]"
        return f"{left}{self.low:.15g}, {self.high:.15g}{right}"


def variables(core: Core) -> tuple[Variable, ...]:
    """All variables in the order of their references, which count from 1.

    Raises:
        ValueRefused: a whole number that 32 bits cannot hold.
    """
    found: list[Variable] = []
    taken = {"time"}
    for name, rest in _all(core):
        unique = name if name not in taken else f"parameters.{name}"
        taken.add(unique)
        found.append(Variable(len(found) + 1, unique, **rest))
    return tuple(found)


def _all(core: Core) -> Iterator[tuple[str, dict[str, Any]]]:
    command = next((p for p in core.inputs if p.role == "command"), core.inputs[0])
    for p in core.inputs:
        place = (f"in.{p.name}",)
        yield p.name, {"kind": "real", "causality": "input", "places": place, "start": p.start, **_said(p)}
    for name, start, doc in (
        ("enable", True, "run the controller, or hold the outputs at zero; taking it away clears a fault"),
        ("index_enable", False, "as LinuxCNC has it: when it falls, the coordinates jump and the controller sees none"),
    ):
        yield name, {"kind": "bool", "causality": "input", "places": (name,), "start": start, "doc": doc}

    for p in core.outputs:
        yield p.name, {"kind": "real", "causality": "output", "places": (f"machine.{p.name}",), **_said(p)}
    for name, kind, unit, doc in (
        ("error", "real", command.unit, "command - feedback"),
        ("saturated", "bool", "", "whether an output is at limits.max_output"),
        ("fault", "bool", "", "whether the outputs are held at zero by a fault"),
        ("fault_code", "int", "", "0 runs, 1 a number was not finite, 2 following error, 3 moved the wrong way"),
    ):
        place = ("machine.fault" if name.startswith("fault") else f"machine.{name}",)
        yield name, {"kind": kind, "causality": "output", "places": place, "unit": unit, "doc": doc}

    tuned = {"causality": "parameter"}
    for knob in core.knobs:
        yield _structured(knob.key), {**tuned, **_tuned(knob, core.real)}
    for name, unit, doc in (
        ("max_output", core.outputs[0].unit, "size of an output; 0: no limit"),
        ("max_error", command.unit, "size of the following error; 0: no limit"),
        ("max_wrong_way", command.unit, "way against the output while it should close the error; 0: no limit"),
    ):
        rest = {"kind": "real", "places": (f"machine.{name}",), "unit": unit, "doc": doc, "low": 0.0}
        yield f"limits.{name}", {**tuned, **rest, "start": _rounded(getattr(core.limits, name), core.real)}
    if core.bumpless:
        doc = "when enabled, go on from an output of zero without a jump; false: from the start state, as simulated"
        yield "bumpless", {**tuned, "kind": "bool", "places": ("machine.bumpless",), "start": False, "doc": doc}
    for role in ("command-deriv", "command-accel"):
        for p in [p for p in core.inputs if p.role == role][:1]:
            rest = {"kind": "bool", "places": (f"machine.derive_{p.name}",), "start": False}
            yield f"derive_{p.name}", {**tuned, **rest, "doc": f"differentiate the command, for want of {p.name}"}


def _said(port: Port) -> dict[str, Any]:
    return {"unit": port.unit, "doc": port.doc or port.key}


def _tuned(knob: Knob, real: str) -> dict[str, Any]:
    """What a knob says about itself, in numbers that the controller can hold."""
    rest: dict[str, Any] = {"kind": {"float": "real"}.get(knob.kind, knob.kind), "unit": knob.unit, "doc": knob.doc}
    rest["places"] = tuple(f"machine.params.{place}" for place in knob.places)
    if knob.kind == "bool":
        return {**rest, "start": bool(knob.value)}
    if knob.kind == "choice":
        return {**rest, "start": int(knob.value), "low": knob.low, "high": knob.high, "names": knob.names}
    rest |= {"open_low": knob.range.startswith("("), "open_high": knob.range.endswith(")")}
    if knob.kind == "int":
        if abs(knob.value) > _INTEGER:
            raise ValueRefused(
                f"{knob.key} = {knob.value}: an FMU holds whole numbers up to {_INTEGER}; do not export it"
            )
        low, high = max(knob.low, -_INTEGER), min(knob.high, _INTEGER)
        open_low = rest["open_low"] and low == knob.low
        open_high = rest["open_high"] and high == knob.high
        return {
            **rest,
            "start": int(knob.value),
            "low": low,
            "high": high,
            "open_low": open_low,
            "open_high": open_high,
        }
    low, high = _rounded(knob.low, real), _rounded(knob.high, real)
    return {**rest, "start": _rounded(knob.value, real), "low": low, "high": high}


def _rounded(value: float, real: str) -> float:
    return float(np.float32(value)) if real == "float" else float(value)


def _structured(key: str) -> str:
    """A dotted key as FMI's structured names allow it: a part that is no identifier stands in quotes."""
    return ".".join(part if _PLAIN.fullmatch(part) else f"'{part}'" for part in key.split("."))


_KINDS = {
    2: {"real": "Real", "int": "Integer", "bool": "Boolean", "choice": "Enumeration"},
    3: {"real": "Float64", "int": "Int32", "bool": "Boolean", "choice": "Enumeration"},
}
_STATE = {2: "FMUstate", 3: "FMUState"}
_TOKEN = {2: "guid", 3: "instantiationToken"}


def model_description(core: Core, variables: tuple[Variable, ...], version: int, token: str, sources: list[str]) -> str:
    """``modelDescription.xml`` for FMI 2 or 3; ``sources`` are the C files to compile."""
    root = ET.Element("fmiModelDescription", fmiVersion=f"{version}.0", modelName=core.title)
    root.set(_TOKEN[version], token)
    root.set("description", one_line(core.doc))
    root.set("generationTool", "Leadscrew")
    root.set("variableNamingConvention", "structured")
    _interface(root, core, version, sources)
    _units(root, ["s", *(v.unit for v in variables)])
    _types(root, variables, version)
    categories = ET.SubElement(root, "LogCategories")
    for name in ("logStatusError", "logStatusWarning"):
        ET.SubElement(categories, "Category", name=name)
    ET.SubElement(root, "DefaultExperiment", startTime="0.0", stepSize=repr(core.period))
    (_variables_2 if version == 2 else _variables_3)(root, variables)
    return _text(root)


def build_description(core: Core, sources: list[str]) -> str:
    """``buildDescription.xml``: how an FMI 3.0 importer compiles the sources."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    build = ET.SubElement(root, "BuildConfiguration", modelIdentifier=core.name)
    files = ET.SubElement(build, "SourceFileSet", language="C99")
    for name in sources:
        ET.SubElement(files, "SourceFile", name=name)
    ET.SubElement(build, "Library", name="m", external="true")
    return _text(root)


def _interface(root: ET.Element, core: Core, version: int, sources: list[str]) -> None:
    one = ET.SubElement(root, "CoSimulation", modelIdentifier=core.name)
    one.set("canHandleVariableCommunicationStepSize", "true")
    one.set(f"canGetAndSet{_STATE[version]}", "true")
    one.set(f"canSerialize{_STATE[version]}", "true")
    if version == 3:
        one.set("fixedInternalStepSize", repr(core.period))
        return
    one.set("canNotUseMemoryManagementFunctions", "true")
    files = ET.SubElement(one, "SourceFiles")
    for name in sources:
        ET.SubElement(files, "File", name=name)


def _units(root: ET.Element, names: Iterable[str]) -> None:
    units = ET.SubElement(root, "UnitDefinitions")
    for name in sorted({n for n in names if n}):
        unit = ET.SubElement(units, "Unit", name=name)
        known = base_units(name)
        if known:
            factor, exponents = known
            base = ET.SubElement(unit, "BaseUnit", {b: str(n) for b, n in exponents.items()})
            if factor != 1.0:
                base.set("factor", repr(factor))


def _types(root: ET.Element, variables: tuple[Variable, ...], version: int) -> None:
    """One enumeration for each parameter that is a choice; its items have the numbers of the C."""
    enumerations = [v for v in variables if v.names]
    if not enumerations:
        return
    types = ET.SubElement(root, "TypeDefinitions")
    for v in enumerations:
        if version == 2:
            listed = ET.SubElement(ET.SubElement(types, "SimpleType", name=_type(v)), "Enumeration")
        else:
            listed = ET.SubElement(types, "EnumerationType", name=_type(v))
        for i, name in enumerate(v.names):
            ET.SubElement(listed, "Item", name=name, value=str(i))


def _type(v: Variable) -> str:
    """The name of a choice's type, unlike that of any variable."""
    return f"{v.name} (choice)"


def _attributes(v: Variable) -> dict[str, str]:
    rest = {"name": v.name, "valueReference": str(v.reference)}
    if v.doc:
        rest["description"] = one_line(v.doc)
    variability = "tunable" if v.causality == "parameter" else "discrete"
    rest |= {"causality": v.causality, "variability": variability}
    if v.causality != "input":
        rest["initial"] = "exact" if v.causality == "parameter" else "calculated"
    return rest


def _typed(v: Variable) -> dict[str, str]:
    """What a variable says in its own kind of number."""
    rest = {"declaredType": _type(v)} if v.names else {}
    if v.unit and v.kind == "real":
        rest["unit"] = v.unit
    for name, bound in (("min", v.low), ("max", v.high)):
        if math.isfinite(bound):
            rest[name] = _value(bound, v.kind)
    if v.start is not None:
        rest["start"] = _value(v.start, v.kind)
    return rest


def _variables_2(root: ET.Element, variables: tuple[Variable, ...]) -> None:
    listed = ET.SubElement(root, "ModelVariables")
    for v in variables:
        ET.SubElement(ET.SubElement(listed, "ScalarVariable", _attributes(v)), _KINDS[2][v.kind], _typed(v))
    structure = ET.SubElement(root, "ModelStructure")
    for name in ("Outputs", "InitialUnknowns"):
        group = ET.SubElement(structure, name)
        for at, v in enumerate(variables, 1):
            if v.causality == "output":
                ET.SubElement(group, "Unknown", index=str(at), dependencies="")


def _variables_3(root: ET.Element, variables: tuple[Variable, ...]) -> None:
    listed = ET.SubElement(root, "ModelVariables")
    time = {"name": "time", "valueReference": "0", "causality": "independent", "variability": "continuous", "unit": "s"}
    ET.SubElement(listed, "Float64", time)
    for v in variables:
        ET.SubElement(listed, _KINDS[3][v.kind], _attributes(v) | _typed(v))
    structure = ET.SubElement(root, "ModelStructure")
    for name in ("Output", "InitialUnknown"):
        for v in variables:
            if v.causality == "output":
                ET.SubElement(structure, name, valueReference=str(v.reference), dependencies="")


def _value(value: float | int | bool, kind: str) -> str:
    if kind == "bool":
        return "true" if value else "false"
    return str(int(value)) if kind in ("int", "choice") else repr(float(value))


def _text(root: ET.Element) -> str:
    for element in root.iter():
        element.attrib.update({key: visible(value) for key, value in element.attrib.items()})
    ET.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(root, encoding="unicode")}\n'


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
