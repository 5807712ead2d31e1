"""A real panel with a real machine, used as a page uses it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import httpx
import numpy as np
import pytest

from leadscrew.operate import session_file
from tests.panel.served import Served

pytestmark = pytest.mark.slow


def session_of(served, folder, name="session.toml"):
    text = served.get(f"api/{name}").text
    path = folder / name
    path.write_text(text)
    return session_file.read(path)


def test_what_is_seen_is_what_the_machine_did(served, page, tmp_path):
    page.did("start")
    page.listen(1.0)
    page.did("set", changes={"controller.kp": 0.02})
    page.listen(0.5)
    page.did("hold")
    page.listen(0.3)
    rerun = session_of(served, tmp_path).run(record=("feedback", "output"))
    assert rerun.identical, rerun.difference
    periods, seen = page.column("feedback")
    np.testing.assert_array_equal(periods, np.arange(len(periods)))
    np.testing.assert_array_equal(seen, rerun.signals["feedback"][: len(seen)].astype(np.float32))
    assert len(seen) == rerun.operated.period and len(seen) * page.machine["period_s"] == pytest.approx(1.5, abs=0.4)


def test_the_script_that_is_downloaded_makes_the_run_again(served, page, tmp_path):
    page.did("start")
    page.did("set", changes={"controller.t_d": 0.001})
    page.did("switch", controller="corrected.vud_beta_e")
    page.listen(0.5)
    page.did("stop")
    script = tmp_path / "session.py"
    script.write_text(served.get("api/session.py").text)
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and "identical" in done.stdout, done.stdout + done.stderr
    report = served.get("api/report.html")
    assert report.status_code == 200 and "corrected.vud_beta_e" in report.text and "<figure" in report.text
    page.did("session_save", name="kept")
    assert session_file.read(served.folder / "sessions" / "kept.toml") == session_of(served, tmp_path)
    assert page.ask("session_save", name="kept")["ok"] is False


def test_time_runs_faster_and_in_slow_motion(page):
    page.did("start")
    page.listen(0.3)
    passed = []
    for speed in (0.1, 1.0, 10.0):
        before = page.did("speed", value=speed)["t"]
        page.listen(2.0)
        passed.append(page.did("speed", value=speed)["t"] - before)
    assert 0.0 < passed[0] < passed[1] < passed[2]
    assert page.ask("speed", value=20.5)["ok"] is False
    page.did("speed", value=1.0)


def test_hold_keeps_time_and_stop_begins_a_new_run_with_what_was_set(page):
    page.did("start")
    page.listen(0.3)
    page.did("set", changes={"controller.kp": 0.03})
    held = page.did("hold")["period"]
    page.listen(0.4)
    assert page.until(lambda s: s["running"] == "held")["period"] == held
    assert page.ask("hold")["ok"] is False
    run = page.machine["run"]
    page.did("stop")
    page.until(lambda s: s["running"] == "stopped" and s["t"] == 0)
    assert page.machine["run"] == run + 1
    kp = next(p for p in page.machine["parameters"] if p["key"] == "controller.kp")
    assert kp["value"] == 0.03
    page.did("start")
    page.listen(0.3)
    page.did("reset")
    state = page.until(lambda s: s["t"] < 0.3)
    assert state["running"] == "running" and page.machine["run"] == run + 2


def test_a_change_is_seen_beside_what_would_have_been(page):
    page.did("start")
    page.listen(0.3)
    done = page.did("set", changes={"controller.kp": 0.05})
    assert done["old"] != done["new"] and done["how"] in ("aligned", "ramped", "at once")
    page.listen(0.6)
    periods, ghost = page.column("output", kind=2)
    assert periods[0] == done["period"] and len(ghost) > 20
    live_periods, live = page.column("output")
    both = np.isin(live_periods, periods)
    assert not np.array_equal(live[both][: len(ghost)], ghost[: both.sum()])
    assert page.state["ghost"]["since_s"] == pytest.approx(done["t"])
    assert page.state["figures"]["rms_ghost"] is not None and page.state["can_undo"]
    assert page.did("undo")["new"] == done["old"]
    assert page.did("redo")["new"] == done["new"]
    page.did("compare", mode="off")
    page.until(lambda s: s["ghost"] is None)
    page.did("compare", mode="previous")


def test_a_refused_value_says_the_range_and_changes_nothing(page):
    page.did("start")
    reply = page.ask("set", changes={"controller.kp": 0.01, "controller.t_d": -1e9})
    assert reply["ok"] is False and reply["key"] == "controller.t_d" and "allowed range" in reply["error"]
    reply = page.ask("set", changes={"controller.kq": 1})
    assert "did you mean" in reply["error"]
    assert page.until(lambda s: True)["changed"] == {}
    assert page.ask("switch", controller="ours.pdd")["ok"] is False
    assert page.ask("disturb", name="earthquake")["ok"] is False
    assert page.ask("machine", study="/etc/passwd")["ok"] is False
    assert page.ask("machine", study="other/file.py:STUDY")["ok"] is False
    assert page.until(lambda s: True)["running"] == "running"


def test_a_preset_brings_controller_and_values_back(served, page):
    page.did("start")
    page.did("set", changes={"controller.kp": 0.011})
    page.did("preset_save", name="gentle")
    page.did("switch", controller="corrected.vud_beta_e")
    page.until(lambda s: True)
    assert page.machine["controller"] == "corrected.vud_beta_e"
    page.did("preset_load", name="gentle")
    kp = page.wait(lambda m: m.get("kind") == "state")["changed"].get("controller.kp")
    told = {p["key"]: p["value"] for p in page.machine["parameters"]}
    assert page.machine["controller"] == "ours.pd" and 0.011 in (kp, told["controller.kp"])
    path = served.folder / "presets" / "gentle.json"
    path.write_text(path.read_text().replace("0.011", "-5e9"))
    assert page.ask("preset_load", name="gentle")["ok"] is False
    page.did("machine", study="grey_turning")
    assert "vud_lathe" in page.ask("preset_load", name="gentle")["error"]
    page.did("preset_delete", name="gentle")
    assert page.did("presets")["presets"] == []


def test_a_capture_is_taken_kept_and_comes_back_with_the_same_bits(served, page):
    page.did("start")
    page.did("arm", signal="feedback", level=-5.0, slope="either", mode="single", pre=0.5, length_s=0.4)
    first = page.wait(lambda m: m.get("kind") == "capture")["capture"]
    page.listen(0.2)
    _, _, number, rows = next((f[1], f[2], f[1], f[4]) for f in page.frames if f[0] == 3)
    assert number == first["id"] and rows.shape == (first["rows"], len(first["columns"]))
    at = first["columns"].index("feedback")
    crossing = rows[first["trigger_row"] - 1 : first["trigger_row"] + 1, at]
    assert min(crossing) <= -5.0 <= max(crossing)
    assert first["about"]["controller"] == "ours.pd" and "controller.kp" in first["about"]["values"]
    for format in ("parquet", "csv", "mat"):
        page.did("capture_save", name="taken", format=format, which=first["id"])
        page.frames.clear()
        number = page.did("capture_load", name=f"taken.{format}")["capture"]
        page.listen(0.3)
        back = next(f[4] for f in page.frames if f[0] == 3 and f[1] == number)
        np.testing.assert_array_equal(back, rows)
        sent = served.get(f"api/captures/taken.{format}")
        assert sent.content == (served.folder / "captures" / f"taken.{format}").read_bytes()
        headers = {
            **served.bearer, "origin": f"http://{served.address}", "leadscrew-secret": "secret-of-this-test"
        }  # fmt: skip
        url = f"http://{served.address}/api/captures/sent.{format}"
        assert httpx.post(url, content=sent.content, headers=headers).json()["rows"] == len(rows)
        assert httpx.post(url, content=b"nothing of the kind", headers=headers).status_code == 400


def test_the_reasons_come_ten_times_a_second_and_only_while_somebody_looks(served, page):
    page.did("machine", study="vud_lathe", controller="corrected.vud_beta_e")
    page.did("start")
    page.did("why", views=["rules", "sets"])
    page.texts.clear()
    page.listen(2.0)
    seen = [m for m in page.texts if m.get("kind") == "why"]
    assert 12 <= len(seen) <= 22 and set(seen[-1]["views"]) == {"rules", "sets"}
    shares = [rule["share"] for rule in seen[-1]["views"]["rules"]["rules"]]
    assert shares and min(shares) > 0.0 and abs(sum(shares) - 1.0) < 1e-3
    page.did("why", views=[])
    page.listen(0.3)
    page.texts.clear()
    page.listen(0.6)
    assert not [m for m in page.texts if m.get("kind") == "why"]


@pytest.mark.parametrize("study", ["fsmc_ballscrew", "grey_turning", "npid_xytable", "sofnn_tangent", "vud_lathe"])
def test_every_machine_runs_is_changed_is_disturbed_and_runs_again_with_the_same_bits(served, page, tmp_path, study):
    page.did("machine", study=study)
    page.until(lambda s: s["t"] == 0 and s["running"] == "stopped")
    page.did("start")
    page.listen(0.4)
    knob = next(p for p in page.machine["parameters"] if p["live"] and p["type"] == "float" and p["value"]
                and p["key"].startswith("controller."))  # fmt: skip
    page.did("set", changes={knob["key"]: knob["value"] * 1.01})
    for disturbance in page.machine["disturbances"]:
        page.did("disturb", name=disturbance["name"], fields={})
    page.listen(0.5)
    page.did("hold")
    assert page.state["message"] == ""
    rerun = session_of(served, tmp_path).run(record=())
    assert rerun.identical, rerun.difference
    shown = {t["signal"] for p in page.machine["plots"] for t in p["traces"]}
    assert shown <= {c["name"] for c in page.machine["columns"]}


@pytest.mark.parametrize("name", ["STUDY", "LOOP"])
def test_a_file_of_ones_own_named_on_the_command_line_is_a_machine(tmp_path, name):
    panel = Served(tmp_path, f"{Path(__file__).parents[1] / 'cli' / 'plain_study.py'}:{name}")
    try:
        page = panel.page()
        if not page.machine:
            page.wait(lambda m: m.get("kind") == "machine")
        assert page.machine["plots"] and bool(page.machine["controllers"]) == (name == "STUDY")
        page.did("take")
        page.did("start")
        page.until(lambda s: s["t"] > 0.2)
        page.did("set", changes={"controller.kp": 2.5})
        assert page.did("undo")["old"]["controller.kp"] == 2.5
    finally:
        panel.end()


def test_a_loop_that_diverges_stands_still_and_is_whole_again_after_stop(tmp_path):
    panel = Served(tmp_path, f"{Path(__file__).parents[1] / 'cli' / 'plain_study.py'}:STUDY", "-c", "p")
    try:
        page = panel.page()
        if not page.machine:
            page.wait(lambda m: m.get("kind") == "machine")
        page.did("take")
        before = next(p["value"] for p in page.machine["parameters"] if p["key"] == "controller.kp")
        page.did("start")
        page.did("set", changes={"controller.kp": 1e9})
        notice = page.wait(lambda m: m.get("kind") == "notice" and m["level"] == "error")
        assert "diverged" in notice["text"] and "Stop or reset" in notice["text"]
        state = page.until(lambda s: s["running"] == "diverged")
        assert state["message"]
        assert page.ask("set", changes={"controller.kp": 1.0})["ok"] is False
        assert "diverged" in page.ask("start")["error"]
        page.did("stop")
        page.until(lambda s: s["running"] == "stopped" and s["t"] == 0)
        assert before == next(p["value"] for p in page.machine["parameters"] if p["key"] == "controller.kp")
        page.did("start")
        page.until(lambda s: s["t"] > 0.1 and s["running"] == "running")
    finally:
        panel.end()


def test_stop_and_start_at_once_is_a_new_run(page):
    page.did("start")
    page.listen(0.3)
    run = page.machine["run"]
    page.send("stop")
    page.did("start")
    page.until(lambda s: s["running"] == "running" and 0.1 < s["t"] < 1.0)
    assert page.machine["run"] == run + 1
