"""``leadscrew list``, ``diff``, ``version``, ``cache``, ``bench``: what a user sees of them."""

from __future__ import annotations

import sys
from types import ModuleType

from leadscrew import __version__
from tests.cli.conftest import FILE, strict_json


def test_list_names_every_block_with_its_kind_and_one_line(call):
    out = call("list").stdout
    assert "lathe_servo" in out and "plant" in out and "vud_lathe" in out
    rows = strict_json(call("list", "--json").stdout)
    assert {b["kind"] for b in rows["blocks"]} >= {"reference", "sensor", "controller", "plant", "metric"}
    assert all(b["doc"] for b in rows["blocks"]) and all("``" not in b["doc"] for b in rows["blocks"])
    assert {m["name"] for m in rows["makers"]} >= {"state_space", "waypoints"}


def test_list_of_a_block_is_its_data_sheet(call):
    out = call("list", "step_load").stdout
    assert "time" in out and "[0, inf)" in out and " s " in out
    sheet = strict_json(call("list", f"{FILE}:gain", "--json").stdout)
    kp = sheet["parameters"][0]
    assert (kp["key"], kp["unit"], kp["default"], kp["range"]) == ("kp", "V/mm", 2.0, "[0, inf)")


def test_help_texts_in_square_brackets_are_not_taken_for_styles(call):
    assert "volt per millimetre [of error]" in call("list", f"{FILE}:gain").stdout


def test_list_of_a_study_shows_what_can_be_set_and_where(call, study):
    found = strict_json(call("list", study, "--json").stdout)
    rk4 = {"method": "rk4", "substeps": 1, "rtol": None, "atol": None}
    assert found["integration"] == dict.fromkeys((s["name"] for s in found["scenarios"]), rk4)
    assert "\nplant integrated by rk4 (1 step a period)\n" in call("list", study).stdout
    by_key = {}
    for row in found["settings"]:
        by_key.setdefault(row["key"], []).append(row)
    assert by_key["scenario.target_mm"][0]["unit"] == "mm"
    assert {tuple(r["where"]): r["default"] for r in by_key["controller.kp"]} == {
        ("p",): 2.0,
        ("p_half", "paper.half"): 1.0,
    }
    assert by_key["plant.lag_s"][0]["where"] == []
    assert {m["name"]: m["unit"] for m in found["metrics"]} == {"rms_error": "mm", "max_error": "mm"}
    out = call("list", study).stdout
    assert "plant.lag_s" in out and "one millimetre" in out


def test_an_unknown_name_gets_the_nearest(refused):
    assert "vud_lathe" in refused("list", "vud_late")
    assert "sine" in refused("list", "sinus")


def test_diff_shows_changed_equations_and_values(call, study):
    out = call("diff", study, "p", "paper.half").stdout
    assert "-def gain(p, command, feedback):" in out and "+def half(p, command, feedback):" in out
    assert '"""' not in out
    found = strict_json(call("diff", study, "p", "p_half", "--json").stdout)
    assert found["equations"] == []
    assert found["parameters"] == [{"key": "kp", "a": 2.0, "b": 1.0, "unit": "V/mm"}]
    assert "The equations are the same." in call("diff", study, "p", "p_half").stdout
    assert "The parameters are the same." in call("diff", study, "p", "p").stdout


def test_diff_of_the_lathe_shows_the_one_changed_equation(call):
    lines = strict_json(call("diff", "vud_lathe", "paper.vud", "corrected.vud_beta_e", "--json").stdout)["equations"]
    assert any(line.startswith("-") and "contraction(s.rho" in line for line in lines)
    assert any(line.startswith("+") and "contraction(now.e" in line for line in lines)


def test_version(call):
    assert call("--version").stdout == f"leadscrew {__version__}\n"
    assert strict_json(call("version", "--json").stdout)["leadscrew"] == __version__
    assert f"leadscrew {__version__}" in call("version").stdout


def test_cache_is_shown_and_cleared(call, tmp_path, monkeypatch):
    monkeypatch.setenv("LEADSCREW_CACHE_DIR", str(tmp_path))
    folder = tmp_path / "0.1.0-py3.11-llvmlite0.50.0"
    folder.mkdir()
    (folder / "loop_abc.o").write_text("x = 1\n")
    found = strict_json(call("cache", "info", "--json").stdout)
    assert found == {
        "schema_version": 1, "kind": "leadscrew cache info", "folder": str(tmp_path), "modules": 1, "bytes": 6,
    }  # fmt: skip
    assert str(tmp_path) in call("cache", "info").stdout
    assert strict_json(call("cache", "clear", "--json").stdout)["modules"] == 1
    assert strict_json(call("cache", "info", "--json").stdout)["modules"] == 0
    call("cache", "clear")


def test_bench_prints_the_rows_that_it_gets(call, monkeypatch):
    rows_of_a_fake_bench(monkeypatch)
    rows = strict_json(call("bench", "--quick", "--json").stdout)["rows"]
    assert rows[0] == {"what": "single", "us": 1.25, "quick": True} and rows[1]["us"] is None
    assert "single" in call("bench").stdout


def test_bench_measures_only_the_parts_that_are_asked_for(call, refused, monkeypatch):
    rows_of_a_fake_bench(monkeypatch)
    every, some = (strict_json(call("bench", "--json", *only).stdout)["rows"] for only in ((), ("--only", "panel")))
    assert [row["what"] for row in every] == ["single", "C", "panel"] and [row["what"] for row in some] == ["panel"]
    assert "--only 'panl'" in (said := refused("bench", "--only", "panl")) and "panel" in said


def rows_of_a_fake_bench(monkeypatch) -> None:
    """In place of the bench, one that measures nothing."""
    rows = {"single": 1.25, "C": None, "panel": 2.0}
    fake = ModuleType("leadscrew.bench")
    fake.PARTS = tuple(rows)
    fake.run = lambda quick, progress, parts: [{"what": part, "us": rows[part], "quick": quick} for part in parts]
    monkeypatch.setitem(sys.modules, "leadscrew.bench", fake)


def test_bench_that_is_not_installed_says_so(refused, monkeypatch):
    monkeypatch.setitem(sys.modules, "leadscrew.bench", None)
    assert "not in this installation" in refused("bench")
