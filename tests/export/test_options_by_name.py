"""Options of an exported controller: constants in C, enumerations in an FMU, named values in HAL."""

import re
import shutil
import subprocess
import zipfile
from io import BytesIO
from xml.etree import ElementTree

import pytest

from leadscrew.export import fmu, hal
from leadscrew.export.controller import export_controller
from leadscrew.references._step import step
from leadscrew.studies.npid_xytable.tunings import table_pid
from tests.controllers.xy_loop import xy_loop
from tests.tools import missing

OPTIONS = ["none", "clamping", "back-calculation"]


@pytest.fixture(scope="module")
def core():
    loop = xy_loop(table_pid(lower=-5.0, upper=5.0, anti_windup="back-calculation"), step(target=1.0))
    return export_controller(loop, 0.05, name="axis", title="axis")[0]


def test_the_header_names_every_option_and_the_defaults_have_the_chosen_one(core, tmp_path):
    if shutil.which("gcc") is None:
        missing("gcc", "not installed")
    for name, text in core.files.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "say.c").write_text(
        '#include <stdio.h>\n#include "axis.h"\nint main(void)\n{\n    axis_params p;\n    axis_defaults(&p);\n'
        '    printf("%d %d ", AXIS_ANTI_WINDUP_NONE, AXIS_ANTI_WINDUP_CLAMPING);\n'
        '    printf("%d %d", AXIS_ANTI_WINDUP_BACK_CALCULATION,\n'
        "           p.anti_windup == AXIS_ANTI_WINDUP_BACK_CALCULATION);\n    return 0;\n}\n"
    )
    build = ["gcc", "-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "say.c", "axis.c", "-lm", "-o", "say"]
    subprocess.run(build, cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "say"], capture_output=True, text=True).stdout == "0 1 2 1"
    assert "anti_windup; /* of the integral, at the limit of output: 0 none, 1 clamping, 2" in core.files["axis.h"]


@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_has_an_enumeration_with_the_numbers_of_the_c(core, version):
    archive = zipfile.ZipFile(BytesIO(fmu.build(core, version, None)))
    root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    variable = next(e for e in root.iter() if e.get("name") == "anti_windup")
    value = variable[0] if version == 2 else variable
    assert (value.tag, value.get("start"), value.get("min"), value.get("max")) == ("Enumeration", "2", "0", "2")
    (type_,) = (e for e in root.iter() if e.get("name") == value.get("declaredType"))
    assert [(i.get("name"), i.get("value")) for i in type_.iter("Item")] == [(o, str(k)) for k, o in enumerate(OPTIONS)]
    assert sum(e.get("name") == value.get("declaredType") for e in root.iter()) == 1


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_an_importer_reads_the_names_and_sets_an_option_but_none_that_there_is_not(core, version, tmp_path):
    fmpy = pytest.importorskip("fmpy")
    from fmpy.fmi1 import FMICallException
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Slave
    from fmpy.validation import validate_fmu

    if shutil.which("gcc") is None:
        missing("gcc", "not installed")
    (tmp_path / "axis.fmu").write_bytes(fmu.build(core, version, "gcc"))
    assert validate_fmu(tmp_path / "axis.fmu") == []
    about = fmpy.read_model_description(tmp_path / "axis.fmu")
    (variable,) = (v for v in about.modelVariables if v.name == "anti_windup")
    assert [item.name for item in variable.declaredType.items] == OPTIONS
    fmpy.extract(tmp_path / "axis.fmu", tmp_path / "unit")
    unit = (FMU2Slave if version == 2 else FMU3Slave)(
        guid=about.guid, unzipDirectory=tmp_path / "unit", modelIdentifier="axis", instanceName="unit"
    )
    unit.instantiate()
    put, get = (unit.setInteger, unit.getInteger) if version == 2 else (unit.setInt64, unit.getInt64)
    reference = [variable.valueReference]
    assert list(get(reference)) == [2]
    put(reference, [1])
    assert list(get(reference)) == [1]
    for wrong in (3, -1, *([2**32] if version == 3 else [])):
        with pytest.raises(FMICallException):
            put(reference, [wrong])
    assert list(get(reference)) == [1]
    unit.freeInstance()


def test_hal_has_a_number_whose_description_names_the_options(core):
    comp, page = hal.files(core)["axis.comp"], hal.readme(core)
    assert re.search(r'param rw s32 anti[-_]windup = 2 ".*: 0 none, 1 clamping, 2 back-calculation";', comp)
    (row,) = (line for line in page.splitlines() if line.startswith("| `anti-windup` |"))
    assert "| 2 | 0 none, 1 clamping, 2 back-calculation |" in row


def test_the_manifest_has_the_names(core):
    assert core.manifest["parameters"]["anti_windup"] == "back-calculation"
    (knob,) = (k for k in core.manifest["knobs"] if k["key"] == "anti_windup")
    assert (knob["kind"], knob["value"], list(knob["names"])) == ("choice", 2, OPTIONS)
