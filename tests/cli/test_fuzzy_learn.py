"""``leadscrew fuzzy learn``: from a log to a file of rules, and what it refuses."""

import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import typer
from typer.testing import CliRunner

from leadscrew.cli.exit_codes import Door
from leadscrew.cli.fuzzy import learn
from leadscrew.fuzzy import formats
from leadscrew.fuzzy.evaluate import compiled

app = typer.Typer(cls=Door)
app.command("learn")(learn)
app.callback()(lambda: None)


@pytest.fixture
def log(tmp_path):
    rng = np.random.default_rng(4)
    e, de = rng.uniform(-1.0, 1.0, (2, 600))
    u = -np.tanh(1.5 * e + 0.7 * de)
    path = tmp_path / "axis.csv"
    rows = "\n".join(f"{k},{a!r},{b!r},{c!r}" for k, (a, b, c) in enumerate(zip(e, de, u, strict=True)))
    path.write_text(f"t,e,de,u\n{rows}\n".replace("np.float64(", "").replace(")", ""))
    return path


def call(*args, code=0):
    result = CliRunner().invoke(app, ["learn", *map(str, args)])
    assert result.exit_code == code, result.output
    return result


def refused(*args):
    result = call(*args, code=2)
    assert result.stdout == "" and result.stderr.count("\n") == 1, result.stderr
    return result.stderr


def test_a_log_becomes_a_file_that_gives_what_was_logged(log, tmp_path):
    out = tmp_path / "axis.fis"
    result = call(log, "--inputs", "e,de", "--output", "u", "--sets", 7, "--sets", "de=5", "--hold-out", 0.2, "-o", out)
    assert "35 of 35 cells covered" in result.stdout and "held out: 120 samples" in result.stdout
    assert f"{out}: 35 rules" in result.stdout
    system = formats.read(out)
    assert [len(v.terms) for v in system.inputs] == [7, 5] and system.name == "axis"
    assert compiled(system).scalar(0.5, 0.0) == pytest.approx(-np.tanh(0.75), abs=0.17)


@pytest.mark.parametrize("suffix", ["fll", "fcl"])
def test_the_other_formats_are_written_too(log, tmp_path, suffix):
    out = tmp_path / f"axis.{suffix}"
    call(log, "--inputs", "e", "--output", "u", "-o", out)
    assert len(formats.read(out).rules) == 7


def test_json_holds_choices_coverage_conflicts_and_scores(log):
    text = call(log, "--inputs", "e,de", "--output", "u", "--hold-out", 0.25, "--seed", 3, "--json").stdout
    assert text.count("\n") == 1
    found = json.loads(text)
    assert found["schema_version"] == 1 and found["choices"]["seed"] == 3 and found["out"] is None
    assert found["learning"]["covered"] == len(found["learning"]["rules"]) == 49
    assert found["learning"]["conflicts"] == sum(bool(rule["beat"]) for rule in found["learning"]["rules"])
    assert found["held_out"]["samples"] == 150 and found["held_out"]["rmse"] < 0.1 < found["held_out"]["spread"]


def test_completion_says_what_it_filled(tmp_path):
    path = tmp_path / "half.csv"
    path.write_text("e,u\n-1,1\n-0.5,0.5\n")
    bare = call(path, "--inputs", "e", "--output", "u", "--sets", 5, "--symmetric")
    assert "2 of 5 cells covered (40.0 %)" in bare.stdout and "no sample covers (ZE), (PS), (PB)" in bare.stdout
    full = call(path, "--inputs", "e", "--output", "u", "--sets", 5, "--complete", "antisymmetric")
    assert "antisymmetric: 3 cells filled: (ZE) -> ZE, (PS) -> NS, (PB) -> NB" in full.stdout
    assert "1-2 from data (Wang and Mendel); 3-5 filled by antisymmetric" in full.stdout
    fall = call(path, "--inputs", "e", "--output", "u", "--sets", 5, "--complete", "monotone", "--falling", "e")
    assert "monotone: 3 cells filled" in fall.stdout


def test_the_output_where_no_rule_fires_can_be_chosen(tmp_path):
    path = tmp_path / "half.csv"
    path.write_text("e,u\n-1,1\n-0.5,0.5\n")
    args = [path, "--inputs", "e", "--output", "u", "--sets", 5, "--symmetric"]
    call(*args, "-o", tmp_path / "bare.fll")
    call(*args, "--default", -0.25, "-o", tmp_path / "given.fll")
    bare, given = (formats.read(tmp_path / f"{name}.fll") for name in ("bare", "given"))
    assert np.isnan(compiled(bare).scalar(0.9)) and compiled(given).scalar(0.9) == -0.25
    assert compiled(given).scalar(-0.8) == compiled(bare).scalar(-0.8)
    choices = [json.loads(call(*args, *more, "--json").stdout)["choices"] for more in ([], ["--default", -0.25])]
    assert [c["default"] for c in choices] == [None, -0.25]


def test_curvature_follows_from_accuracy_and_reading(log):
    args = [log, "--inputs", "e,de", "--output", "u"]
    assert "read as full" in call(*args, "--accuracy", 0.05, "--reading", "full").stdout
    assert "half, full or intervals" in refused(*args, "--accuracy", 0.05)


def test_parquet_gives_the_same_rules_as_csv(log, tmp_path):
    columns = np.genfromtxt(log, delimiter=",", names=True)
    path = tmp_path / "axis.parquet"
    pq.write_table(pa.table({n: columns[n] for n in ("e", "de", "u")}), path)
    args = ["--inputs", "e,de", "--output", "u", "--json"]
    a, b = (json.loads(call(p, *args).stdout) for p in (log, path))
    assert a["learning"] == b["learning"]


def test_what_is_wrong_with_a_log_is_said_with_row_and_column(tmp_path):
    args = ["--inputs", "e", "--output", "u"]
    path = tmp_path / "bad.csv"
    path.write_text("e,u\n1,2\n3,x\n")
    assert "row 3, column 'u': 'x' is not a number" in refused(path, *args)
    path.write_text("e,v\n1,2\n")
    assert "has no column 'u'" in refused(path, *args)
    table = tmp_path / "bad.parquet"
    pq.write_table(pa.table({"e": [1.0, 2.0], "u": [1.0, None]}), table)
    assert "sample 2, column 'u': holds no finite number" in refused(table, *args)
    pq.write_table(pa.table({"e": [1.0, 2.0], "u": ["a", "b"]}), table)
    assert "column 'u': holds words" in refused(table, *args)
    pq.write_table(pa.table({"e": [1.0]}), table)
    assert "has no column 'u'" in refused(table, *args)
    table.write_text("nothing")
    assert "cannot be read" in refused(table, *args)
    assert "cannot be read" in refused(tmp_path / "none.csv", *args)


@pytest.mark.parametrize(
    ("extra", "said"),
    [
        (["--sets", "x"], "--sets 'x'"),
        (["--sets", "q=5"], "no variable 'q'"),
        (["--sets", "1"], "allowed are 2 to 999"),
        (["--percentiles", "1"], "two numbers"),
        (["--percentiles", "90,10"], "rising"),
        (["--rising", "e", "--falling", "e"], "both name e"),
        (["--complete", "monotone"], "needs a direction"),
        (["--complete", "guess"], "no step of completion 'guess'"),
        (["--complete", "monotone", "--rising", "q"], "no input 'q'"),
        (["--ties", "guess"], "'drop' and 'keep'"),
        (["--hold-out", "1.5"], "allowed is 0 to 0.9"),
        (["--default", "inf"], "allowed is a finite number"),
        (["--grid", "fine"], "even, quantile, curvature"),
        (["--rule-weights", "some"], "none, strength"),
        (["--weights", "t"], "row 0 (from 0): 0.0: allowed is above 0 to 1"),
        (["--inputs", "e,,de"], "expected names"),
        (["-o", "x.txt"], ".txt"),
    ],
)
def test_choices_that_make_no_sense_are_refused_in_one_line(log, extra, said):
    assert said in refused(log, "--inputs", "e,de", "--output", "u", *extra)
