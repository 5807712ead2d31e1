"""``leadscrew fuzzy``: files shown, converted, evaluated, drawn; what is wrong with them, in one sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from leadscrew.fuzzy import formats
from leadscrew.fuzzy.evaluate import compiled
from tests.budget import in_every_run
from tests.cli.conftest import FLL, left, strict_json
from tests.fuzzy.formats_systems import shared
from tests.fuzzy.systems import mamdani, sugeno


# ---- show
def test_show_says_terms_rules_norms_and_the_way_of_evaluation(call, feeder, servo, tmp_path):
    out = call("fuzzy", "show", feeder).stdout
    for words in ("1 input, 1 output, 2 rules", "0 to 10", "start 4, end 0", "value 0.1", "weighted average",
                  "where no rule fires NaN", "   2  if gap is far then feed is fast", "general: 2 rules"):  # fmt: skip
        assert words in out
    assert "active rules: a table" in call("fuzzy", "show", servo).stdout
    other = tmp_path / "mamdani.fll"
    formats.write(mamdani(integration="exact"), other)
    assert "closed form" in call("fuzzy", "show", other).stdout
    formats.write(mamdani(), other)
    out = call("fuzzy", "show", other).stdout
    assert "centroid by midpoint on 100 cells" in out and "and minimum, or maximum, implication minimum" in out


def test_show_as_json_is_the_whole_system(call, feeder):
    found = strict_json(call("fuzzy", "show", feeder, "--json").stdout)
    assert found["schema_version"] == 1 and found["name"] == "feeder" and found["notes"] == []
    near = found["inputs"][0]["terms"][0]
    assert (near["name"], near["shape"], near["parameters"]) == ("near", "ramp", [4.0, 0.0])
    assert near["names"] == ["start", "end"]
    assert found["outputs"][0]["default"] is None
    assert found["blocks"][0]["rules"][1] == {
        "number": 2, "text": "if gap is far then feed is fast", "weight": 1.0, "enabled": True,
    }  # fmt: skip
    assert found["evaluation"] == {"feed": "general: 2 rules, then weighted average"}


def test_infinite_parameters_are_words_in_json(call, tmp_path):
    path = tmp_path / "wide.fll"
    path.write_text(FLL.format(fast="fast").replace("Ramp 4.000 0.000", "Triangle -inf 0.000 4.000"))
    found = strict_json(call("fuzzy", "show", path, "--json").stdout)
    assert found["inputs"][0]["terms"][0]["parameters"] == ["-inf", 0.0, 4.0]
    assert "a -inf, b 0, c 4" in call("fuzzy", "show", path).stdout


def test_a_system_that_cannot_be_evaluated_is_shown_with_the_reason(call, tmp_path):
    path = tmp_path / "norules.fll"
    path.write_text("\n".join(line for line in FLL.format(fast="fast").splitlines() if "rule:" not in line))
    out = call("fuzzy", "show", path).stdout
    assert "cannot be evaluated: system feeder: it needs inputs, outputs and rules" in out


@pytest.mark.parametrize("suffix", in_every_run(["png", "svg", "pdf"], ["svg"]))
def test_show_draws_the_membership_functions(call, feeder, tmp_path, suffix):
    out = tmp_path / "new" / f"terms.{suffix}"
    assert str(out) in call("fuzzy", "show", feeder, "--plot", out).stdout
    first = out.read_bytes()
    assert first.startswith({"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[suffix])
    call("fuzzy", "show", feeder, "--plot", out)
    assert out.read_bytes() == first
    assert left(out.parent) == [out.name]


# ---- errors
def test_an_unknown_term_is_refused_with_its_place_and_the_option_that_leaves_it_out(call, refused, broken, tmp_path):
    for command in (
        ("show",), ("eval", "gap=1"), ("surface", "-o", tmp_path / "x.png"), ("bench",),
        ("activity", tmp_path / "run.csv"), ("convert", tmp_path / "x.fis"),
    ):  # fmt: skip
        said = refused("fuzzy", command[0], broken, *command[1:])
        assert f"{broken}:25:" in said and "'quick'" in said
        assert said.endswith("(--leave-out-unknown leaves such rules out)\n")
    shown = call("fuzzy", "show", broken, "--leave-out-unknown")
    assert "1 rule" in shown.stdout and "leadscrew: note: " in shown.stderr and "is left out" in shown.stderr
    assert left(tmp_path) == ["broken.fll"]


def test_a_file_that_is_broken_otherwise_has_no_such_hint(refused, tmp_path):
    path = tmp_path / "bad.fll"
    path.write_text(FLL.format(fast="fast").replace("range: 0.000 10.000", "range: 0.000 ten"))
    said = refused("fuzzy", "show", path)
    assert f"{path}:4:" in said and "leave-out" not in said
    assert "cannot be read" in refused("fuzzy", "show", tmp_path / "missing.fis")
    path.write_bytes(b"\x00\x01")
    assert "binary" in refused("fuzzy", "show", path)


def test_other_suffixes_are_refused_before_anything_is_read(refused, feeder, tmp_path):
    assert "x.bmp: a picture ends in .png, .svg, .pdf" in refused("fuzzy", "show", feeder, "--plot", "x.bmp")
    assert "allowed are .fis, .fll, .fcl" in refused("fuzzy", "convert", feeder, "x.xml")
    assert "no suffix" in refused("fuzzy", "surface", "nothing.fis", "-o", "picture")


# ---- convert
def test_convert_gives_the_same_outputs_and_replaces_only_when_told(call, refused, feeder, tmp_path):
    target = tmp_path / "feeder.fis"
    assert f"{target}: feeder, 2 rules" in call("fuzzy", "convert", feeder, target).stdout
    a, b = (compiled(formats.read(p)) for p in (feeder, target))
    assert [a.scalar(x) for x in (0.0, 3.0, 7.0)] == [b.scalar(x) for x in (0.0, 3.0, 7.0)]
    before = target.read_bytes()
    assert "--force replaces it" in refused("fuzzy", "convert", feeder, target)
    found = strict_json(call("fuzzy", "convert", feeder, target, "--force", "--json").stdout)
    assert found["to"] == str(target) and found["rules"] == 2 and found["read"] == []
    assert "the name of rule block 'only' is not written" in found["not_said"]
    assert target.read_bytes() == before


def test_convert_says_what_the_format_cannot(call, refused, tmp_path, feeder):
    text = FLL.format(fast="fast")
    feeder.write_text(text.replace("Engine: feeder", "Engine: feeder\ndescription: a lathe's feed"))
    out = call("fuzzy", "convert", feeder, tmp_path / "a.fis").stdout
    assert "not in this format: descriptions are not written" in out
    feeder.write_text(text.replace("default: nan", "default: 0.5"))
    assert "cannot express output feed: a default" in refused("fuzzy", "convert", feeder, tmp_path / "b.fis")
    assert left(tmp_path) == ["a.fis", "feeder.fll"]


# ---- eval
def test_eval_at_a_point_gives_the_library_numbers(call, servo):
    f = compiled(sugeno())
    assert call("fuzzy", "eval", servo, "e=0.1", "de=-0.2").stdout == f"u = {f.scalar(0.1, -0.2)!r}\n"
    found = strict_json(call("fuzzy", "eval", servo, "de=-0.2", "e=0.1", "--explain", "--json").stdout)
    assert found["outputs"] == {"u": f.scalar(0.1, -0.2)} and found["inputs"] == {"de": -0.2, "e": 0.1}
    assert found["explanation"]["total"] == 49
    assert sum(s["part"] for r in found["explanation"]["rules"] for s in r["shares"]) == pytest.approx(1.0)
    out = call("fuzzy", "eval", servo, "e=0.1", "de=-0.2", "--explain", "--engine", "python").stdout
    assert "4 of 49 rules fire:" in out and "because e is ZE: 0.7" in out


def test_no_value_is_null_in_json_and_nan_in_words(call, feeder):
    assert strict_json(call("fuzzy", "eval", feeder, "gap=5", "--json").stdout)["outputs"] == {"feed": None}
    assert call("fuzzy", "eval", feeder, "gap=5").stdout == "feed = nan\n"
    assert call("fuzzy", "eval", feeder, "gap=-inf").stdout == "feed = 0.1\n"


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("gap=x",), "gap = 'x': expected a number"),
        (("gap",), "expected NAME=VALUE"),
        (("gap=1", "gap=2"), "given twice"),
        (("gip=1",), "no input 'gip'; did you mean gap"),
        ((), "no value for the input gap"),
        (("gap=1", "--engine", "fortran"), "no engine 'fortran'"),
        (("gap=1", "-o", "x.csv"), "--points FILE only"),
        (("gap=1", "--points", "x.csv"), "no INPUT=VALUE"),
        (("--points", "missing.csv"), "missing.csv: cannot be read"),
        (("--points", "missing.parquet"), "missing.parquet: cannot be read"),
        (("--points", "x.csv", "-o", "y.txt"), "allowed are .csv, .parquet"),
    ],
)
def test_bad_values_are_refused(refused, feeder, args, words):
    assert words in refused("fuzzy", "eval", feeder, *args)


def points(folder: Path, text: str) -> Path:
    path = folder / "points.csv"
    path.write_text(text)
    return path


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
@pytest.mark.parametrize("engine", ["llvm", "python"])
def test_eval_at_the_points_of_a_file(call, servo, tmp_path, suffix, engine):
    x = np.random.default_rng(3).uniform(-1.2, 1.2, (50, 2))
    given = points(tmp_path, "de,other,e\n" + "".join(f"{float(b)!r},1,{float(a)!r}\n" for a, b in x))
    out = tmp_path / f"out.{suffix}"
    said = call("fuzzy", "eval", servo, "--points", given, "-o", out, "--engine", engine).stdout
    assert said == f"{out}: 50 points, u\n"
    if suffix == "csv":
        assert out.read_text().splitlines()[0] == "e,de,u"
        found = np.loadtxt(out, delimiter=",", skiprows=1)
    else:
        table = pq.read_table(out)
        assert table.column_names == ["e", "de", "u"]
        found = np.column_stack([table.column(n).to_numpy() for n in table.column_names])
    assert np.array_equal(found, np.column_stack([x, compiled(sugeno()).many(x)]))


def test_points_without_a_file_to_write_go_to_standard_output(call, feeder, tmp_path):
    given = points(tmp_path, "gap\n0\n5\n10\n")
    assert call("fuzzy", "eval", feeder, "--points", given).stdout == "gap,feed\n0.0,0.1\n5.0,nan\n10.0,1.0\n"
    found = strict_json(call("fuzzy", "eval", feeder, "--points", given, "--json").stdout)
    assert found["outputs"] == {"feed": [0.1, None, 1.0]} and found["points"] == 3 and found["out"] is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("gip\n1\n", ("row 1", "the column 'gap' is missing", "did you mean gip")),
        ("gap\n1\nx\n", ("row 3", "column 'gap'", "'x' is not a number")),
        ("gap,b\n1,2\n3\n", ("row 3", "1 cells where the header has 2")),
        ("gap\n", ("no rows",)),
        ("", ("is empty",)),
    ],
)
def test_broken_points_are_refused_with_row_and_column(refused, feeder, tmp_path, text, words):
    said = refused("fuzzy", "eval", feeder, "--points", points(tmp_path, text), "-o", tmp_path / "o.csv")
    assert all(word in said for word in (str(tmp_path / "points.csv"), *words))
    assert left(tmp_path) == ["feeder.fll", "points.csv"]


def test_broken_parquet_is_refused(refused, feeder, tmp_path):
    path = tmp_path / "p.parquet"
    for table, words in (
        ({"gip": [1.0]}, "the column 'gap' is missing"),
        ({"gap": ["one"]}, "holds no numbers"),
        ({"gap": [1.0, float("nan")]}, "row 2, column 'gap'"),
    ):
        pq.write_table(pa.table(table), path)
        assert words in refused("fuzzy", "eval", feeder, "--points", path)
    path.write_text("no parquet")
    assert "p.parquet" in refused("fuzzy", "eval", feeder, "--points", path)


# ---- files of others
def test_the_crane_of_others(call, refused, tmp_path):
    crane = shared("data/fuzzy/container_crane.fcl")
    said = refused("fuzzy", "show", crane)
    assert "container_crane.fcl:43:65: power has no term 'pos_big'" in said and "--leave-out-unknown" in said
    assert "5 rules" in call("fuzzy", "show", crane, "--leave-out-unknown").stdout
    found = call("fuzzy", "eval", crane, "--leave-out-unknown", "distance=15", "angle=0", "--json").stdout
    assert strict_json(found)["outputs"] == {"power": pytest.approx(12.0)}
    out = call("fuzzy", "convert", crane, tmp_path / "crane.fll", "--leave-out-unknown").stdout
    assert "read: " in out and "is left out" in out
