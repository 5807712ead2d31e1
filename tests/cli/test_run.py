"""``leadscrew run``: the report, its folder, the exit codes."""

from __future__ import annotations

import shutil

from leadscrew.kernel.run import load
from tests.cli.conftest import FILE, strict_json


def test_run_prints_claims_and_writes_the_report(call, study, tmp_path):
    out = tmp_path / "deep" / "report"
    said = call("run", study, "--out", out).stdout
    assert "plain.denied" in said and "not reproduced" in said and "forgets" in said
    assert "2 of 2 required targets met" in said and str(out / "report.html") in said
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "A finding &amp; more." in page and "statement &lt;kept&gt;" in page
    manifest, signals = load(out / "runs" / "small__p")
    assert manifest["origin"]["study"] == study and len(signals["time"]) == 200
    assert [p.name for p in out.parent.iterdir()] == ["report"]
    assert "identical" in call("replay", out / "runs" / "small__p").stdout


def test_json_is_one_strict_object(call, study, tmp_path):
    out = tmp_path / "report"
    found = strict_json(call("run", study, "--out", out, "--json", "--no-figures").stdout)
    assert list(found) == ["study", "version", "schema_version", "wall_s", "claims", "report"]
    assert [c["passed"] for c in found["claims"]] == [True, True, None]
    assert found["claims"][2]["measured"] is None
    assert found["report"] == str(out / "report.html")
    assert "data:image" not in (out / "report.html").read_text(encoding="utf-8")


def test_a_missed_required_target_ends_with_code_1(call, tmp_path):
    said = call("run", f"{FILE}:MISSED", "--out", tmp_path / "r", "--no-figures", code=1).stdout
    assert "MISSED plain.missed" in said and "2 of 3 required targets met" in said
    assert (tmp_path / "r" / "report.html").is_file()


def test_an_older_report_is_replaced_and_nothing_else_ever_is(call, refused, study, tmp_path):
    out = tmp_path / "report"
    call("run", study, "--out", out, "--no-figures")
    (out / "stale").write_text("of the older report")
    call("run", study, "--out", out, "--no-figures")
    assert not (out / "stale").exists() and [p.name for p in tmp_path.iterdir()] == ["report"]
    shutil.rmtree(out)
    out.mkdir()
    call("run", study, "--out", out, "--no-figures")
    (out / "report.json").write_text('{"schema_version": 1, "kind": "a report of somebody else"}')
    assert "not a report of ours" in refused("run", study, "--out", out)
    (out / "report.json").unlink()
    assert "not a report of ours" in refused("run", study, "--out", out)
    (tmp_path / "file").write_text("x")
    assert "not a folder" in refused("run", study, "--out", tmp_path / "file")
    assert "cannot be written" in refused("run", study, "--out", tmp_path / "file" / "below")


def test_a_report_that_fails_half_way_leaves_the_older_one(call, study, tmp_path, monkeypatch):
    out = tmp_path / "report"
    call("run", study, "--out", out, "--no-figures")
    before = (out / "report.json").read_text()

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("leadscrew.report.html.render", full)
    assert "No space left" in call("run", study, "--out", out, code=2).stderr
    assert (out / "report.json").read_text() == before and [p.name for p in tmp_path.iterdir()] == ["report"]
