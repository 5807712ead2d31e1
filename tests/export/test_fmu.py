"""What stands in an FMU: archive, description, units, sources."""

import dataclasses
import io
import re
import shutil
import subprocess
import zipfile
from xml.etree import ElementTree as ET

import pytest

from leadscrew.export import fmu
from leadscrew.export.core import Knob, Limits
from leadscrew.export.fmu import base_units, variables
from leadscrew.util.errors import LeadscrewError, ValueRefused
from tests.export.fmu_sample import core, record
from tests.tools import missing, needed

VERSIONS = pytest.mark.parametrize("version", [2, 3])


def opened(archive: bytes) -> zipfile.ZipFile:
    return zipfile.ZipFile(io.BytesIO(archive))


@pytest.fixture
def gcc():
    if not shutil.which("gcc"):
        missing("gcc", "gcc is not installed")
    return "gcc"


@VERSIONS
def test_the_same_core_gives_the_same_bytes_and_any_change_another_token(version, gcc):
    first = fmu.build(core(), version, gcc, record(50))
    assert first == fmu.build(core(), version, gcc, record(50))

    def token(of):
        root = ET.fromstring(opened(fmu.build(of, version, None)).read("modelDescription.xml"))
        return root.get("guid") or root.get("instantiationToken")

    others = [core(KP=0.26), core("float"), dataclasses.replace(core(), doc="Another.")]
    assert len({token(of) for of in (core(), *others)}) == 4


@VERSIONS
def test_the_archive_holds_sources_binary_documents_and_vectors(version, gcc):
    names = opened(fmu.build(core(), version, gcc, record(5))).namelist()
    platform = {2: "linux64", 3: "x86_64-linux"}[version]
    assert f"binaries/{platform}/sample.so" in names
    assert {"sources/sample.c", "sources/sample_machine.h", f"sources/sample_fmi{version}.c"} <= set(names)
    assert {"documentation/README.md", "documentation/index.html", "documentation/licenses/fmi.txt"} <= set(names)
    assert "resources/golden.csv" in names
    assert ("sources/buildDescription.xml" in names) == (version == 3)


@VERSIONS
def test_without_a_compiler_there_are_sources_only(version):
    names = opened(fmu.build(core(), version, None)).namelist()
    assert not [n for n in names if n.startswith(("binaries", "resources"))]


@VERSIONS
@pytest.mark.parametrize("real", ["double", "float"])
def test_fmpy_validation_finds_nothing(version, real, tmp_path):
    needed("fmpy", "verify")
    from fmpy.validation import validate_fmu

    file = tmp_path / "sample.fmu"
    file.write_bytes(fmu.build(core(real), version, None, record(5)))
    assert validate_fmu(str(file)) == []


def test_fmpy_validation_would_find_an_undeclared_unit(tmp_path):
    needed("fmpy", "verify")
    from fmpy.validation import validate_fmu

    with opened(fmu.build(core(), 2, None)) as good, zipfile.ZipFile(tmp_path / "bad.fmu", "w") as bad:
        for name in good.namelist():
            bad.writestr(name, good.read(name).replace(b'<Unit name="mm">', b'<Unit name="inch">'))
    assert "mm" in validate_fmu(str(tmp_path / "bad.fmu"))[0]


def test_the_build_description_keeps_the_schema(tmp_path):
    needed("fmpy", "verify")
    from pathlib import Path

    import fmpy
    from lxml import etree

    schema = etree.XMLSchema(file=str(Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3BuildDescription.xsd"))
    text = opened(fmu.build(core(), 3, None)).read("sources/buildDescription.xml")
    schema.assertValid(etree.fromstring(text))


def test_all_functions_of_the_standard_are_exported_and_nothing_else(tmp_path, gcc):
    if not shutil.which("nm"):
        missing("nm", "nm is not installed")
    for version, platform, wanted in ((2, "linux64", 34), (3, "x86_64-linux", 75)):
        with opened(fmu.build(core(), version, gcc)) as archive:
            archive.extractall(tmp_path)
        command = ["nm", "-D", "--defined-only", str(tmp_path / f"binaries/{platform}/sample.so")]
        exported = {line.split()[-1] for line in subprocess.check_output(command, text=True).splitlines()}
        header = (tmp_path / f"sources/fmi{version}Functions.h").read_text()
        declared = set(re.findall(rf"FMI{version}_Export fmi\w+TYPE\s+(fmi\w+);", header))
        model_exchange = set(
            re.findall(r"\w+", header.partition("Model Exchange\n")[2].partition("Co-Simulation\n")[0])
        )
        assert exported == (declared - model_exchange if version == 2 else declared)
        assert len(exported) == wanted


@VERSIONS
def test_variables_say_names_units_ranges_and_exact_starts(version):
    root = ET.fromstring(opened(fmu.build(core(), version, None)).read("modelDescription.xml"))
    said = {}
    for tag in root.find("ModelVariables"):
        said[tag.get("name")] = {**tag.attrib, **(tag[0].attrib if version == 2 else {})}
    assert root.get("variableNamingConvention") == "structured"
    assert said["command"]["causality"] == "input" and said["command"]["unit"] == "mm"
    assert (said["enable"]["start"], said["index_enable"]["start"]) == ("true", "false")
    assert {n for n, x in said.items() if x["causality"] == "output"} == {
        "output", "error", "saturated", "fault", "fault_code",
    }  # fmt: skip
    kd = said["gains.kd"]
    assert (kd["start"], kd["min"], kd["max"], kd["unit"], kd["variability"]) == (
        "0.004", "0.0", "0.1", "V s/mm", "tunable",
    )  # fmt: skip
    assert "max" not in said["kp"]
    assert (said["mode"]["start"], said["mode"]["max"]) == ("1", "3")
    assert said["limits.max_output"]["start"] == "0.75"
    assert "tau.'0'" in said
    assert said["parameters.enable"]["causality"] == "parameter"
    assert said["derive_command_velocity"]["start"] == "false"


def test_single_precision_starts_and_ranges_are_what_the_controller_holds():
    found = {v.name: v for v in variables(core("float"))}
    assert found["gains.kd"].start == 0.004000000189989805
    assert found["gains.kd"].high == 0.10000000149011612
    assert found["gains.kd"].kind == "real"


@pytest.mark.parametrize(
    ("unit", "factor", "exponents"),
    [
        ("1", 1.0, {}),
        ("mm/s", 1e-3, {"m": 1, "s": -1}),
        ("1/mm", 1e3, {"m": -1}),
        ("V/mm", 1e3, {"kg": 1, "m": 1, "s": -3, "A": -1}),
        ("V/(mm s)", 1e3, {"kg": 1, "m": 1, "s": -4, "A": -1}),
        ("mm/s^2", 1e-3, {"m": 1, "s": -2}),
        ("mm/min", 1e-3 / 60, {"m": 1, "s": -1}),
        ("Nm", 1.0, {"kg": 1, "m": 2, "s": -2}),
        ("kN", 1e3, {"kg": 1, "m": 1, "s": -2}),
        ("um", 1e-6, {"m": 1}),
        ("rad/s", 1.0, {"rad": 1, "s": -1}),
        ("deg", 0.017453292519943295, {"rad": 1}),
        ("Hz", 1.0, {"s": -1}),
        ("%", 0.01, {}),
        ("rpm", 0.10471975511965977, {"rad": 1, "s": -1}),
        ("rev/min", 0.10471975511965977, {"rad": 1, "s": -1}),
        ("g", 1e-3, {"kg": 1}),
        ("mA", 1e-3, {"A": 1}),
        ("cm/h", 1e-2 / 3600, {"m": 1, "s": -1}),
        ("GPa", 1e9, {"kg": 1, "m": -1, "s": -2}),
        ("nm", 1e-9, {"m": 1}),
    ],
)
def test_units_are_told_in_base_units(unit, factor, exponents):
    found = base_units(unit)
    assert found is not None
    assert found == (pytest.approx(factor, rel=1e-15), exponents)


@pytest.mark.parametrize(
    ("unit", "same"),
    [
        ("J", "N m"), ("J", "Nm"), ("W", "J/s"), ("V", "W/A"), ("C", "A s"), ("ohm", "V/A"), ("H", "V s/A"),
        ("F", "A s/V"), ("T", "V s/m^2"), ("Pa", "N/m^2"), ("N", "kg m/s^2"), ("Hz", "1/s"),
    ],
)  # fmt: skip
def test_derived_units_are_what_the_si_defines_them_by(unit, same):
    assert base_units(unit) == base_units(same)


@pytest.mark.parametrize("unit", ["", "sets", "[error] s", "mm per period", "V/(mm", "mm)", "/", "mm/s^x"])
def test_a_unit_that_is_not_known_keeps_its_name_only(unit):
    assert base_units(unit) is None


def test_an_unknown_unit_still_validates(tmp_path):
    needed("fmpy", "verify")
    from fmpy.validation import validate_fmu

    knob = Knob("rules", "rules", "float", 0.25, ("gains.kp",), "rules per cycle")
    file = tmp_path / "x.fmu"
    file.write_bytes(fmu.build(dataclasses.replace(core(), knobs=(knob,)), 3, None))
    assert validate_fmu(str(file)) == []


def test_what_cannot_be_built_is_refused_in_a_sentence(gcc):
    with pytest.raises(ValueRefused, match="FMI version 1: allowed are 2 and 3"):
        fmu.build(core(), 1, None)
    with pytest.raises(LeadscrewError, match="no-such-cc does not start"):
        fmu.build(core(), 2, "no-such-cc")
    broken = core()
    broken.files["sample.c"] += "int x = y;\n"
    with pytest.raises(LeadscrewError, match=r"gcc refuses the sources of the FMU sample: sample\.c.*error"):
        fmu.build(broken, 2, gcc)
    big = Knob("big", "big", "int", 2**40, ("mode",))
    with pytest.raises(ValueRefused, match="big = 1099511627776: an FMU holds whole numbers up to 2147483647"):
        fmu.build(dataclasses.replace(core(), knobs=(big,)), 3, None)


def test_the_readme_tells_the_step_and_every_variable():
    text = fmu.readme(core("float"), 3)
    assert "FMI 3.0" in text and "0.001 s" in text and "single precision" in text
    assert all(f"`{v.name}`" in text for v in variables(core()))
    assert r"gain \| of error" in text
    assert "single precision" not in fmu.readme(core(), 2)


def test_no_limit_is_a_start_of_zero():
    found = {v.name: v for v in variables(dataclasses.replace(core(), limits=Limits()))}
    assert found["limits.max_output"].start == 0.0
