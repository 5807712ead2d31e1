"""What ``leadscrew export`` and ``verify-export`` refuse: one sentence, exit code 2, and nothing written."""

import json
import shutil

import numpy as np
import pytest

from leadscrew.kernel import engines
from tests.cli.conftest import strict_json
from tests.tools import missing

NPID = "examples/xy_table_npid.py:loop"

UNSUPPORTED = """\
from typing import NamedTuple

from leadscrew import Loop
from leadscrew.kernel.block import controller
from leadscrew.plants._xy_table import xy_table
from leadscrew.references._sine import sine


class Params(NamedTuple):
    gains: tuple = (1.0, 2.0)


@controller()
def odd(command, feedback):
    total = 0.0
    while abs(total) < 3.0:
        total += {"a": 1.0}["a"]
    return total * (command - feedback)


def loop():
    return Loop(reference=sine(), controller=odd, plant=xy_table, period=5e-4, metrics={})
"""
CONTINUOUS = """\
from leadscrew import Loop
from leadscrew.kernel.block import controller
from leadscrew.plants._ballscrew_stage import ballscrew_stage
from leadscrew.references._sine import sine


@controller(continuous=True)
def spring(command, feedback):
    return 20.0 * (command - feedback)


def loop():
    return Loop(reference=sine(), controller=spring, plant=ballscrew_stage, period=None, sample=1e-3, metrics={})
"""


@pytest.fixture
def nothing(tmp_path):
    """A place in which nothing may appear."""
    place = tmp_path / "place"
    place.mkdir()
    yield place
    assert list(place.iterdir()) == []


@pytest.fixture
def no_compiler(monkeypatch, tmp_path):
    """A machine without a C compiler."""
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    engines.c_compiler.cache_clear()
    yield
    engines.c_compiler.cache_clear()


@pytest.fixture
def gcc():
    if not shutil.which("gcc"):
        missing("gcc", "there is no gcc on this machine")


def npid(out, *more, target="c99", seconds=0.05):
    return "export", NPID, "--duration", seconds, "--target", target, "--out", out, *more


@pytest.fixture
def exported(call, gcc, tmp_path):
    """Makes an exported folder."""

    def make(target="c99", *more):
        call(*npid(tmp_path / target, *more, target=target))
        return tmp_path / target

    return make


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--name", "while"), ("name = 'while'", "C language", "--name while_controller")),
        (("--name", "printf"), ("name = 'printf'", "library")),
        (("--name", "class"), ("name = 'class'",)),
        (("--name", "two words"), ("name = 'two words'", "letters, digits and underscores")),
        (("--name", "2nd"), ("name = '2nd'", "a letter first")),
        (("--name", ""), ("name = ''", "a letter first")),
        (("--name", "größe"), ("name = 'größe'", "letters, digits")),
        (("--name", "../up"), ("name = '../up'", "letters, digits")),
        (("--name", "check"), ("name = 'check'", "another file")),
        (("--name", "n" * 26), ("26 characters", "at most 25")),
        (("--name", "pid", "--target", "hal"), ("name = 'pid'", "LinuxCNC", "--name pid_controller")),
        (("--target", "plc"), ("target = 'plc'", "c99, hal, fmu2, fmu3")),
        (("--real", "half"), ("real = 'half'", "double, float")),
        (("--drive", "steam"), ("drive = 'steam'", "torque, force, velocity, voltage")),
        (("--drive", "torque"), ("drive = 'torque'", "npid commands voltage", "10 V")),
        (("--set", "controller.kp=1e300"), ("diverged at t = ", "an export is checked by a run of its loop")),
        (("--set", "controller.kp=-1"), ("controller.kp", "[0, inf)")),
        (("--duration", "0"), ("duration = 0", "(0, inf)")),
        (("--duration", "1e-6"), ("duration = 1e-06 s", "one period of 0.0005 s")),
        (("--controller", "pid"), (NPID, "takes no controller")),
    ],
)
def test_a_bad_option_is_refused(refused, nothing, more, words):
    said = refused(*npid(nothing / "out", *more))
    assert all(w in said for w in words), said


@pytest.mark.parametrize("target", ["c99", "fmu3"])
def test_a_construct_outside_the_subset_is_named_by_file_and_line(refused, nothing, tmp_path, target):
    file = tmp_path / "odd.py"
    file.write_text(UNSUPPORTED)
    line = UNSUPPORTED.splitlines().index('        total += {"a": 1.0}["a"]') + 1
    said = refused("export", f"{file}:loop", "--duration", 0.1, "--target", target, "--out", nothing / "out")
    assert f"{file}:{line}" in said and "dict" in said.lower(), said


def test_a_continuous_controller_has_no_period_to_run_at(refused, nothing, tmp_path):
    file = tmp_path / "spring.py"
    file.write_text(CONTINUOUS)
    said = refused("export", f"{file}:loop", "--duration", 0.1, "--target", "c99", "--out", nothing / "out")
    assert "spring" in said and "no control period" in said


@pytest.mark.parametrize("where", ["file/out", "file/deep/out", "/proc/leadscrew/out"])
def test_a_folder_that_cannot_be_written_is_refused(refused, tmp_path, where):
    (tmp_path / "file").write_text("x")
    said = refused(*npid(tmp_path / where))
    assert str(tmp_path / where) in said and "cannot be written" in said
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_a_folder_with_something_in_it_stays_as_it_is(refused, call, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("x")
    assert "exists already" in refused(*npid(tmp_path / "out"))
    assert [str(p.relative_to(tmp_path)) for p in sorted(tmp_path.rglob("*"))] == ["out", "out/mine.txt"]
    (tmp_path / "empty").mkdir()
    call(*npid(tmp_path / "empty"))
    assert (tmp_path / "empty" / "manifest.json").is_file()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["empty", "out"]


def test_an_export_that_fails_late_leaves_no_folder_above_either(refused, tmp_path):
    long = "n" * 25
    changes = UNSUPPORTED.replace('{"a": 1.0}["a"]', "p.a_parameter_with_a_name_that_is_long")
    changes = changes.replace("gains: tuple = (1.0, 2.0)", "a_parameter_with_a_name_that_is_long: float = 1.0")
    changes = changes.replace("@controller()", "@controller(Params())").replace("odd(command", "odd(p, command")
    (tmp_path / "odd.py").write_text(changes)
    said = refused(
        "export", f"{tmp_path}/odd.py:loop", "--duration", 0.1, "--target", "hal", "--out", tmp_path / "a" / "b",
        "--name", long,
    )  # fmt: skip
    assert "LinuxCNC allows names of 47" in said
    assert not (tmp_path / "a").exists()


@pytest.mark.slow
def test_a_name_that_is_too_long_for_the_simulated_machine_is_refused(refused, nothing):
    asked = ("export", "examples/ballscrew_smc.py:loop", "--duration", 0.1, "--target", "hal", "--out", nothing / "out")
    said = refused(*asked, "--name", "n" * 20)
    assert f"{'n' * 20}-plant.0.command-acceleration has 49 characters" in said


@pytest.mark.parametrize("target", ["c99", "hal"])
def test_without_a_compiler_sources_are_written_and_their_check_is_not_run(call, no_compiler, tmp_path, target):
    said = call(*npid(tmp_path / "out", target=target)).stdout
    assert "not run" in said and "no C compiler" in said
    golden = json.loads((tmp_path / "out" / "manifest.json").read_text())["golden"]
    assert golden["verdict"] == "not run"
    assert "**not run**" in (tmp_path / "out" / "README.md").read_text()


@pytest.mark.parametrize("target", ["fmu2", "fmu3"])
def test_without_a_compiler_an_fmu_has_sources_only(call, refused, no_compiler, tmp_path, target):
    said = refused(*npid(tmp_path / "out", target=target))
    assert "C compiler" in said and "--sources-only" in said
    assert list(tmp_path.iterdir()) == []
    call(*npid(tmp_path / "out", "--sources-only", target=target))
    found = call("verify-export", tmp_path / "out", code=1)
    assert "sources only" in found.stdout and "identical" not in found.stdout
    assert "nothing could be run" in found.stderr


def test_without_a_compiler_engine_c_is_refused(refused, no_compiler):
    said = refused("simulate", NPID, "--duration", 0.1, "--engine", "c")
    assert "no C compiler" in said and "engine='llvm'" in said


def test_without_any_tool_nothing_passes(call, exported, monkeypatch, tmp_path):
    folder = exported("hal")
    monkeypatch.setenv("PATH", str(tmp_path))
    result = call("verify-export", folder, code=1)
    said = result.stdout
    assert "nothing could be run on this machine" in result.stderr
    assert said.count("not run") == 3 and "identical" not in said
    found = strict_json(call("verify-export", folder, "--json", code=1).stdout)
    assert found["passed"] is False and {v["verdict"] for v in found["verdicts"]} == {"not run"}


def test_what_is_no_exported_folder_is_refused(refused, tmp_path):
    (tmp_path / "file").write_text("x")
    for where in ("none", "file", "."):
        said = refused("verify-export", tmp_path / where)
        assert "is not an exported folder" in said and "manifest.json" in said


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "null", "3", '"c99"', "{}", '{"schema_version": 1, "target": "c99"}', "[" * 100_000, "\udcff"],
    ids=["empty", "open", "list", "null", "number", "text", "object", "bare", "deep", "not utf-8"],
)
def test_a_manifest_that_is_not_ours_is_refused(refused, tmp_path, text):
    (tmp_path / "manifest.json").write_bytes(text.encode("utf-8", "surrogateescape"))
    assert "manifest.json" in refused("verify-export", tmp_path)


@pytest.mark.parametrize(
    ("key", "value"),
    [("name", "../x"), ("name", 3), ("target", ["c99"]), ("target", "plc"), ("outputs", []), ("inputs", 7),
     ("period_s", 0), ("limits", {}), ("golden", None), ("schema_version", 2), ("sense", "x"), ("title", None)],
)  # fmt: skip
def test_a_manifest_with_one_thing_wrong_is_refused(refused, exported, key, value):
    folder = exported()
    manifest = json.loads((folder / "manifest.json").read_text())
    (folder / "manifest.json").write_text(json.dumps(manifest | {key: value}))
    assert "not a manifest that leadscrew export wrote" in refused("verify-export", folder)


def verdicts(call, folder):
    """Verdicts by target, of what ran."""
    found = strict_json(call("verify-export", folder, "--json", code=1).stdout)
    assert found["passed"] is False
    return {v["target"]: v for v in found["verdicts"] if v["verdict"] != "not run"}


def test_an_edited_golden_number_is_different(call, exported):
    folder = exported()
    head, *rows = (folder / "golden.csv").read_text().splitlines()
    *first, last = rows[7].split(",")
    rows[7] = ",".join([*first, repr(float(np.nextafter(float(last), 1.0)))])
    (folder / "golden.csv").write_text("\n".join([head, *rows]) + "\n")
    found = verdicts(call, folder)
    assert {v["verdict"] for v in found.values()} == {"different"} and len(found) == 4
    assert all(0.0 < v["worst"] < 1e-12 for v in found.values() if v["target"] != "golden.csv")
    assert "different" in call("verify-export", folder, code=1).stdout


def test_golden_vectors_cut_short_do_not_pass(call, exported):
    folder = exported()
    lines = (folder / "golden.csv").read_text().splitlines()
    (folder / "golden.csv").write_text("\n".join(lines[:3]) + "\n")
    assert verdicts(call, folder)["golden.csv"]["note"] == "not the golden vectors that were exported"


def test_golden_vectors_written_another_way_are_the_same(call, exported):
    folder = exported()
    text = (folder / "golden.csv").read_text().replace("\n", "\r\n")
    (folder / "golden.csv").write_bytes(text.encode())
    call("verify-export", folder)


@pytest.mark.parametrize("text", ["", "a,b\n1,x\n"])
def test_golden_vectors_that_are_no_table_are_refused(refused, exported, text):
    folder = exported()
    (folder / "golden.csv").write_text(text)
    assert "golden.csv: not a table of golden vectors" in refused("verify-export", folder)
    (folder / "golden.csv").unlink()
    assert "golden.csv" in refused("verify-export", folder)


@pytest.mark.parametrize("file", ["npid.c", "npid_machine.c", "check.c"])
def test_an_edited_source_that_does_not_compile_has_failed(call, exported, file):
    folder = exported()
    code = folder / file
    code.write_text(code.read_text() + "\nint broken(void) { return nonsense; }\n")
    found = verdicts(call, folder)
    assert {v["verdict"] for v in found.values()} == {"failed"}
    assert all("nonsense" in v["note"] for v in found.values())


def test_json_of_an_export_is_one_strict_object(call, gcc, tmp_path):
    found = strict_json(call(*npid(tmp_path / "out", "--json")).stdout)
    assert found["out"] == str(tmp_path / "out") and "golden.csv" in found["files"]
    assert found["manifest"] == json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert found["manifest"]["golden"]["verdict"] == "identical" and found["manifest"]["cycles"] == 100
    checked = strict_json(call("verify-export", tmp_path / "out", "--json").stdout)
    assert checked["passed"] is True and checked["target"] == "c99"
