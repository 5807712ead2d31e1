"""What the panel keeps: who changed what, presets, and who has control."""

import json
import shutil
import time
from pathlib import Path

import numpy as np
import pytest

from leadscrew.panel import audit as audit_module
from leadscrew.panel import presets
from leadscrew.panel.audit import Audit
from leadscrew.panel.control import Control
from leadscrew.panel.downloads import SUFFIXES, capture_file, is_capture_name
from leadscrew.panel.strict_json import plain, text_of
from leadscrew.util.errors import DataError, NameUnknown


def test_every_change_is_in_the_log_at_once_with_old_and_new(tmp_path):
    log = Audit(tmp_path)
    log.note("set", who="Ann", client=1, t=2.5, key="controller.kp", old=1.0, new=2.0)
    log.note("set", who="Bob", client=2, key="controller.kp", ok=False, error="Ann has control")
    lines = [json.loads(line) for line in (tmp_path / "audit.jsonl").read_text().splitlines()]
    assert lines == log.last(10)
    assert (lines[0]["who"], lines[0]["old"], lines[0]["new"], lines[0]["t"]) == ("Ann", 1.0, 2.0, 2.5)
    assert lines[1]["ok"] is False and lines[1]["error"] == "Ann has control"
    assert log.last(1) == lines[1:]


def test_the_log_stays_small_and_holds_no_line_of_a_stranger(tmp_path, monkeypatch):
    monkeypatch.setattr(audit_module, "MOST_BYTES", 5000)
    log = Audit(tmp_path)
    for i in range(400):
        log.note(f"x\n{i}", who="\x1b[31mred\r\n{}", new=list(range(1000)), error="e" * 10_000)
    sizes = [p.stat().st_size for p in tmp_path.iterdir()]
    assert len(sizes) <= audit_module.FILES and max(sizes) < 8000
    text = (tmp_path / "audit.jsonl").read_text() + (tmp_path / "audit.1.jsonl").read_text()
    assert all(json.loads(line)["what"].startswith("x ") for line in text.splitlines())
    assert "\x1b" not in text and "399" in log.last(1)[0]["what"]


def test_a_log_that_is_a_link_is_not_written_through(tmp_path):
    (tmp_path / "elsewhere").write_text("")
    (tmp_path / "audit.jsonl").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(DataError, match="cannot be written"):
        Audit(tmp_path)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="posix: no /dev/full")
def test_a_full_disk_does_not_stop_the_panel(tmp_path):
    log = Audit(tmp_path)
    log._file = open("/dev/full", "w")  # noqa: PTH123, SIM115
    log.note("set", who="Ann")
    assert log.last(1)[0]["who"] == "Ann" and "space" in log.problem
    log.note("set", who="Bob")
    assert log.problem == "", "the next entry is written as soon as it can be"


def test_what_is_refused_never_pushes_out_what_was_done(tmp_path):
    log = Audit(tmp_path)
    log.note("set", who="Ann", new=1.0)
    for i in range(3000):
        log.note("set", who="Bob", ok=False, error=f"{i}")
    seen = log.last(200)
    assert seen[0]["who"] == "Ann" and [e["error"] for e in seen[1:]] == [str(i) for i in range(2801, 3000)]
    assert len(log.last(1)) == 1 and log.last(1)[0]["error"] == "2999"


def test_a_log_that_was_removed_is_made_anew(tmp_path):
    log = Audit(tmp_path / "files")
    log.note("set", who="Ann")
    shutil.rmtree(tmp_path / "files")
    log.note("set", who="Bob")
    assert json.loads((tmp_path / "files" / "audit.jsonl").read_text())["who"] == "Bob" and log.problem == ""


def test_a_preset_comes_back_as_it_was_saved(tmp_path):
    saved = presets.Preset(
        "vud_lathe", "ours.pd", {"controller.kp": 0.1 + 0.2, "plant.table": [[1.0, 2.0]], "controller.on": True}
    )
    assert presets.save(saved, tmp_path, "a b").name == "a b.json"
    assert presets.load(tmp_path, "a b") == saved
    assert presets.names(tmp_path) == ["a b"]
    presets.delete(tmp_path, "a b")
    assert presets.names(tmp_path) == []


@pytest.mark.parametrize("name", ["../a", "/a", ".a", "", "a/b", "a..b", "x" * 65, "a\x00", "a\n"])
def test_a_preset_never_leaves_its_folder(tmp_path, name):
    saved, folder = presets.Preset("a", "b", {}), tmp_path / "home" / "presets"
    acts = (
        lambda: presets.save(saved, folder, name),
        lambda: presets.load(folder, name),
        lambda: presets.delete(folder, name),
    )
    for act in acts:
        with pytest.raises((DataError, NameUnknown)):
            act()
    assert list(tmp_path.rglob("*.json")) == []


@pytest.mark.parametrize(
    "text, why",
    [("{", "no preset"), ("[]", "no preset"), ("[" * 100_000, "no preset"),
     ('{"schema_version":1}', "'study' is missing"),
     ('{"schema_version":2,"study":"a","controller":"b","values":{}}', "schema_version = 2"),
     ('{"schema_version":1,"study":1,"controller":"b","values":{}}', "study = 1: Input should be a valid string"),
     ('{"schema_version":1,"study":"a","controller":"b","values":[]}', "valid dictionary"),
     ('{"schema_version":1,"study":"a","controller":"b","values":{"k":NaN}}', "NaN"),
     (" " * 300_000, "more than 256000 bytes"),
     ('{"schema_version":1,"study":"a","controller":"b","values":{"k":1e999}}', "beyond"),
     ('{"schema_version":1,"study":"a","controller":"b","values":{"k":' + "9" * 4000 + "}}", "4000 digits"),
     ('{"schema_version":1,"study":"a","controller":"b","values":{"k":' + "[" * 900 + "]" * 900 + "}}", "nested"),
     ('{"schema_version":1,"study":"a","controller":"b","values":{"k":1,"k":2}}', "repeated")],
)  # fmt: skip
def test_a_file_that_is_no_preset_is_refused(tmp_path, text, why):
    (tmp_path / "p.json").write_text(text)
    with pytest.raises(DataError, match=why):
        presets.load(tmp_path, "p")


def test_a_preset_that_the_disk_does_not_give_or_take_is_refused_and_no_error_of_the_program(tmp_path, monkeypatch):
    """An error of the program stops the machine."""
    presets.save(presets.Preset("a", "b", {"k": 1.0}), tmp_path, "p")

    def failing(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", failing)
    monkeypatch.setattr(Path, "unlink", failing)
    for act in (presets.load, presets.delete):
        with pytest.raises(DataError, match=r"p\.json cannot be .*: Permission denied"):
            act(tmp_path, "p")


def test_a_preset_that_is_a_link_is_not_followed(tmp_path):
    (tmp_path / "secret").write_text("{}")
    (tmp_path / "p.json").symlink_to(tmp_path / "secret")
    with pytest.raises((DataError, NameUnknown)):
        presets.load(tmp_path, "p")
    with pytest.raises(DataError, match="link"):
        presets.save(presets.Preset("a", "b", {}), tmp_path, "p")


def test_one_page_writes_and_the_next_only_when_it_is_free():
    control = Control(30.0)
    assert control.take(1, "Ann", "secret-of-ann-1234") == ""
    assert "Ann has control" in control.take(2, "Bob", "secret-of-bob-1234")
    assert control.has(1) and not control.has(2)
    control.release()
    assert control.take(2, "Bob", "secret-of-bob-1234") == ""


def test_control_waits_for_its_page_and_for_no_other(monkeypatch):
    control = Control(30.0)
    control.take(1, "Ann", "secret-of-ann-1234")
    assert control.lost(1) and not control.lost(2)
    assert control.take(2, "Bob", "secret-of-bob-1234") != ""
    assert control.resume(3, "secret-of-bob-1234") is None and control.resume(3, "") is None
    assert control.resume(3, "secret-of-ann-1234") == -1
    assert control.has(3) and control.resume(4, "secret-of-ann-1234") == 3
    control.lost(4)
    assert control.timed_out() is None
    later = time.monotonic() + 31.0
    monkeypatch.setattr(time, "monotonic", lambda: later)
    gone = control.timed_out()
    assert gone is not None and gone.name == "Ann" and control.timed_out() is None
    assert control.resume(5, "secret-of-ann-1234") is None
    assert control.take(2, "Bob", "secret-of-bob-1234") == ""


def test_a_duplicated_tab_is_the_same_person():
    control = Control(30.0)
    control.take(1, "Ann", "secret-of-ann-1234")
    assert control.resume(2, "secret-of-ann-1234") == 1
    control.lost(2)
    assert control.take(3, "Bob", "secret-of-bob-1234") != "" and control.take(1, "Ann", "secret-of-ann-1234") == ""
    assert control.has(1)


def test_a_page_without_a_secret_cannot_be_resumed_by_another_without():
    control = Control(30.0)
    control.take(1, "Ann", "")
    control.lost(1)
    assert control.resume(2, "") is None


def test_messages_to_a_browser_hold_no_nan():
    found = plain({"a": np.float64("nan"), "b": [np.inf, 1], "c": np.arange(2), "d": np.True_, "e": None, 3: "x"})
    assert found == {"a": None, "b": [None, 1], "c": [0, 1], "d": True, "e": None, "3": "x"}
    assert json.loads(text_of({"a": float("-inf"), "b": np.float32(0.5)})) == {"a": None, "b": 0.5}


def test_a_capture_is_only_found_in_its_folder(tmp_path):
    (tmp_path / "a.csv").write_text("x")
    (tmp_path / "b.csv").symlink_to(tmp_path / "a.csv")
    (tmp_path / "c.sh").write_text("x")
    assert capture_file(tmp_path, "a.csv") == tmp_path / "a.csv"
    for name in ("b.csv", "c.sh", "../a.csv", "a.csv/", "..", "a", "", "a.csv\n", str(tmp_path / "a.csv")):
        assert capture_file(tmp_path, name) is None
    assert not is_capture_name("a..csv")


def test_the_names_of_captures_are_those_that_can_be_read():
    from leadscrew.operate.captures import READ

    assert set(SUFFIXES) == set(READ)
