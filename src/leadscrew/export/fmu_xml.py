"""``modelDescription.xml`` of an FMU, and ``buildDescription.xml`` of an FMI 3.0 one."""

from __future__ import annotations

import math
from collections.abc import Iterable
from xml.etree import ElementTree as ET

from leadscrew.escape import one_line, visible
from leadscrew.export.core import Core
from leadscrew.export.fmu_units import base_units
from leadscrew.export.fmu_variables import Variable

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
        for number, name in enumerate(v.names):
            ET.SubElement(listed, "Item", name=name, value=str(number))


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
