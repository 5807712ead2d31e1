"""A simulated machine under the panel, without server and page: what is kept, what is told, what is refused."""

from __future__ import annotations

import re
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from leadscrew.cli.panel import _spec
from leadscrew.operate import capture_files, captures, session_file
from leadscrew.operate.operated import Start
from leadscrew.panel import description, records, sim_machine
from leadscrew.panel.frames import GHOST, LIVE
from leadscrew.panel.machine import Later
from leadscrew.panel.scope_commands import ScopeCommands
from leadscrew.panel.sim_machine import SimMachine
from leadscrew.panel.worker import machine_of
from leadscrew.util.errors import NameUnknown, ValueRefused

EXAMPLES = Path(__file__).parents[2] / "examples"

ARM = {"signal": "feedback", "level": 1e9, "slope": "rising", "mode": "single", "pre": 0.2, "length_s": 0.1}


def did(machine, do, **args):
    found = machine.ask(do, args)
    return found.done(found.work()) if isinstance(found, Later) else found


def begun(folder, *start, **more):
    machine = SimMachine(Start(*(start or ("npid_xytable", "corrected.npid_um")), **more), folder)
    later = machine.begin()
    later.done(later.work())
    machine.news()
    return machine


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    return begun(tmp_path_factory.mktemp("one"))


@pytest.fixture
def machine(one):
    did(one, "machine", study="npid_xytable", controller="corrected.npid_um", scenario=None, seed=None, circle=False,
        changes=None)  # fmt: skip
    one.news()
    return one


def ran(machine, periods):
    """The machine runs so far, and its rows go where they go in a tick."""
    machine._seen(*machine._here().advance(periods))


def parameter(machine, key):
    return next(p for p in machine.describe()["parameters"] if p["key"] == key)


@pytest.mark.slow
@pytest.mark.parametrize("back", ["undo", "safe", "preset"])
def test_a_controller_of_the_same_columns_is_told_to_the_page_and_so_is_the_way_back(machine, back):
    columns = list(machine.columns)
    did(machine, "preset_save", name=f"first {back}")
    ran(machine, 50)
    did(machine, "arm", **ARM)
    did(machine, "switch", controller="paper.pid")
    assert machine.columns == columns, "else this test is of another case"
    assert ("machine", {}) in machine.news()
    assert machine.describe()["controller"] == "paper.pid" and "paper.pid" in machine.describe()["why_not_views"]
    ran(machine, 1)
    assert machine.state()["scope"]["phase"] == "armed" and machine._about["controller"] == "paper.pid"
    if back == "preset":
        did(machine, "preset_load", name="first preset")
    else:
        did(machine, back, **({"why": "test"} if back == "safe" else {}))
    assert ("machine", {}) in machine.news() and machine.describe()["controller"] == "corrected.npid_um"
    assert machine._about["controller"] == "corrected.npid_um"


@pytest.mark.slow
@pytest.mark.parametrize("way", ["switch", "undo", "redo", "safe", "preset_load", "reset", "stop"])
def test_a_view_that_is_open_while_held_is_of_the_controller_now_or_waits_for_its_first_period(tmp_path, way):
    machine = begun(tmp_path, "vud_lathe", "corrected.vud_beta_e", "s_curve_m50")
    did(machine, "preset_save", name="first")
    did(machine, "start")
    ran(machine, 20)
    did(machine, "hold")
    views = set(machine.describe()["views"])
    assert views == set(machine.why(("rules", "sets", "phase"))["views"]) == {"rules", "sets"}
    columns = machine.columns
    did(machine, "switch", controller="ours.vud_fast")
    assert machine.columns != columns, "else this test is of another case"
    if way == "redo":
        did(machine, "undo")
    if way != "switch":
        ran(machine, 20)
        did(machine, way, **({"why": "test"} if way == "safe" else {"name": "first"} if way == "preset_load" else {}))
    assert machine.why(("rules", "sets", "phase")) == {}
    ran(machine, 1)
    assert set(machine.why(("rules", "sets", "phase"))["views"]) == set(machine.describe()["views"])


@pytest.mark.slow
def test_no_file_that_a_page_names_is_run(machine, tmp_path):
    mark, evil = tmp_path / "was_run", tmp_path / "evil.py"
    evil.write_text(f"open({str(mark)!r}, 'w')\nMINE = None\n")
    wanted = f"{evil}:MINE"
    did(machine, "preset_save", name="evil")
    place = machine.folder / "presets" / "evil.json"
    place.write_text(place.read_text().replace("corrected.npid_um", wanted))
    args = {"study": "npid_xytable", "scenario": None, "seed": None, "circle": False, "changes": None}
    for do, said in (
        ("machine", {**args, "controller": wanted}),
        ("machine", {**args, "controller": None, "scenario": wanted}),
        ("machine", {**args, "controller": None, "study": wanted}),
        ("switch", {"controller": wanted}),
        ("preset_load", {"name": "evil"}),
    ):
        with pytest.raises(NameUnknown):
            did(machine, do, **said)
    assert not mark.exists() and machine.describe()["controller"] == "corrected.npid_um"


@pytest.mark.slow
def test_a_controller_that_the_command_line_named_is_in_the_list_and_can_be_chosen_again(tmp_path):
    spec = _spec(str(EXAMPLES / "axis_on_the_lathe.toml"), None, None, None, tmp_path)
    machine = machine_of(spec)
    later = machine.begin()
    later.done(later.work())
    told = machine.describe()
    own = told["controller"]
    assert [c["name"] for c in told["controllers"]].count(own) == 1
    other = next(c["name"] for c in told["controllers"] if c["name"] != own)
    for name in (other, own):
        did(machine, "machine", study=told["study"], controller=name, scenario=told["scenario"], seed=None,
            circle=False, changes=None)  # fmt: skip
        assert machine.describe()["controller"] == name


def test_a_study_is_called_by_its_title_and_a_machine_file_by_its_name():
    assert description._title("vud_lathe") == description.study_of("vud_lathe").title != "vud_lathe"
    assert description._title("/somewhere/of mine/axis.toml") == "axis.toml"


@pytest.mark.slow
def test_a_preset_of_what_the_machine_has_already_is_no_error(machine):
    did(machine, "preset_save", name="same")
    assert did(machine, "preset_load", name="same")["new"] == {}


@pytest.mark.slow
def test_the_default_stays_the_studys_over_a_reset_and_what_was_set_stays_set(machine):
    before = parameter(machine, "controller.kp")
    did(machine, "set", changes={"controller.kp": 2.0 * before["value"]})
    for do in ("reset", "stop", "reset"):
        did(machine, do)
        now = parameter(machine, "controller.kp")
        assert (now["value"], now["default"]) == (2.0 * before["value"], before["default"])
    did(machine, "switch", controller="paper.pid")
    own = parameter(machine, "controller.kp")["default"]
    did(machine, "reset")
    assert parameter(machine, "controller.kp")["default"] == own


@pytest.mark.slow
def test_an_option_is_shown_set_refused_and_undone_by_its_name(machine):
    key, names = "controller.anti_windup", ["none", "clamping", "back-calculation"]
    shown = parameter(machine, key)
    assert (shown["type"], shown["choices"], shown["value"], shown["live"]) == ("choice", names, "clamping", True)
    ran(machine, 20)
    assert did(machine, "set", changes={key: "none"})["new"] == {key: "none"}
    assert (
        parameter(machine, key)["value"] == "none" and machine._here().loop.blocks["controller"].params.anti_windup == 0
    )
    with pytest.raises(ValueRefused, match=r"controller.anti_windup = 'nothing'.*there are none, clamping"):
        did(machine, "set", changes={key: "nothing"})
    with pytest.raises(ValueRefused, match=r"kp = 'none'.*expected a number"):
        did(machine, "set", changes={"controller.kp": "none"})
    assert 'anti_windup = "none"' in session_file.text(machine._here().session())
    did(machine, "undo")
    assert parameter(machine, key)["value"] == "clamping"


def test_an_armed_trigger_goes_on_waiting_in_the_next_run(machine):
    did(machine, "arm", **ARM)
    ran(machine, 10)
    for do in ("stop", "reset"):
        did(machine, do)
        assert machine.state()["scope"]["phase"] == "armed"
        assert machine.state()["scope"]["trigger"]["level"] == ARM["level"]
    did(machine, "disarm")
    did(machine, "reset")
    assert machine.state()["scope"]["phase"] == "idle"


@pytest.mark.slow
def test_the_session_of_a_run_that_ends_is_kept_and_runs_again(machine):
    folder = machine.folder / "sessions"
    machine.close()
    known = set(folder.glob("*"))
    ran(machine, 100)
    did(machine, "reset")
    machine.close()
    assert set(folder.glob("*")) == known, "100 periods without an event are nothing to keep"
    ran(machine, 100)
    did(machine, "set", changes={"controller.kp": 2.0})
    ran(machine, 100)
    did(machine, "stop")
    machine.close()
    (kept,) = set(folder.glob("*")) - known
    session = session_file.read(kept)
    assert session.periods == 200 and session.run(record=()).identical
    ran(machine, round(1.0 / machine._here().period_s))
    said = machine.close()
    (last,) = set(folder.glob("*")) - known - {kept}
    assert str(last) in said and session_file.read(last).periods == round(1.0 / machine._here().period_s)


@pytest.mark.slow
def test_of_the_sessions_that_were_kept_the_oldest_go_and_no_other_file(machine, monkeypatch):
    monkeypatch.setattr(records, "KEPT", 3)
    folder = machine.folder / "sessions"
    own = folder / "run of mine.toml"
    folder.mkdir(exist_ok=True)
    own.write_text("mine")
    names = []
    for _ in range(5):
        ran(machine, 1)
        did(machine, "set", changes={"controller.kp": 2.0 + len(names)})
        did(machine, "stop")
        machine.close()
        names = sorted(p.name for p in folder.glob("run-*.toml"))
        time.sleep(0.002)
    assert len(names) == 3 and own.exists() and all(re.match(r"run-\d{8}-\d+\.toml", n) for n in names)


@pytest.mark.slow
def test_values_of_one_axis_of_a_circle_stay_over_a_reset(tmp_path):
    machine = begun(tmp_path, "fsmc_ballscrew", None, "sine_fast", circle=True)
    keys = [k for k, e in machine._here().sheet.items() if k.startswith("controller.") and e.type == "float"]
    one, both = keys[:2]
    old, also = (machine._here().values()[k] for k in (one, both))
    did(machine, "set", changes={f"x.{one}": 1.02 * old})
    did(machine, "set", changes={both: 1.01 * also})
    for do in ("stop", "reset"):
        did(machine, do)
        values = machine._here().values()
        assert (values[one], values[f"y.{one}"]) == (1.02 * old, old)
        assert values[both] == values[f"y.{both}"] == 1.01 * also
    did(machine, "preset_save", name="apart")
    did(machine, "set", changes={f"x.{one}": 1.03 * old})
    did(machine, "preset_load", name="apart")
    values = machine._here().values()
    assert (values[one], values[f"y.{one}"]) == (1.02 * old, old)
    ran(machine, 20)
    assert machine._here().session().run(record=()).identical


def test_a_capture_says_whether_it_was_loaded(tmp_path):
    taking = ScopeCommands(tmp_path)
    taking.watch(["time", "feedback"], {}, 1e-3)
    did(taking, "arm", **{**ARM, "level": 2.0, "length_s": 0.003})
    taking.feed(0, np.column_stack([np.arange(9) * 1e-3, np.arange(9.0)]), {})
    did(taking, "capture_save", name="a", format="csv", which=None)
    did(taking, "capture_load", name="a.csv")
    taken, loaded = (message["capture"] for _, message in taking.news())
    assert (taken["loaded"], loaded["loaded"]) == (False, True) and taken["rows"] == loaded["rows"] > 1


@pytest.mark.parametrize("form", ["csv", *(pytest.param(f, marks=pytest.mark.slow) for f in ("parquet", "mat"))])
def test_a_file_that_a_page_sends_or_opens_is_parsed_in_a_process_of_its_own(tmp_path, monkeypatch, form):
    """What fills the memory or crashes its reader must not take the machine with it."""
    rows = np.column_stack([np.arange(9) * 1e-3, np.arange(9.0)])
    taken = captures.Capture("a", ("time", "feedback"), {"time": "s"}, 1e-3, 4, 2, rows, {"study": "x"})
    sent = captures.save(taken, tmp_path / "elsewhere", "a", form)

    def here(path):
        raise AssertionError(f"{path} is parsed in the machine's process")

    for reader in ("read_own", "read_log"):
        monkeypatch.setattr(capture_files, reader, here)
    taking = ScopeCommands(tmp_path / "captures")
    assert did(taking, "capture_receive", name=f"b.{form}", path=str(sent)) == {"name": "a", "rows": 9}
    did(taking, "capture_load", name=f"b.{form}")
    (seen,) = taking.held.values()
    assert seen.rows.tobytes() == rows.tobytes() and {**vars(seen), "rows": 0} == {**vars(taken), "rows": 0}


@pytest.mark.slow
def test_frames_ghost_and_figures_are_the_rows_of_the_run_again(machine, monkeypatch):
    now = 100.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    did(machine, "start")
    frames = machine.tick(now)
    for k in range(40):
        now += 0.02
        if k == 20:
            changed = did(machine, "set", changes={"controller.kp": 2.0})["period"]
        frames += machine.tick(now)
    did(machine, "hold")
    frames += machine.tick(now)
    operated = machine._here()
    rows = {}
    for kind in (LIVE, GHOST):
        assert all(f.stride == 1.0 for f in frames), "within 2000 rows a second each row is sent"
        found = [(int(f.first) + k, row) for f in frames if f.kind == kind for k, row in enumerate(f.rows)]
        assert [at for at, _ in found] == list(range(0 if kind == LIVE else changed, operated.period))
        rows[kind] = np.array([row for _, row in found])
    session = operated.session()
    again, alone = session.run(record="*"), replace(session, events=()).run(record="*")
    for at, name in enumerate(machine.columns):
        whole = again.signals[name].astype(np.float32), alone.signals[name].astype(np.float32)
        assert np.array_equal(rows[LIVE][:, at], whole[0], equal_nan=True), name
        assert np.array_equal(rows[GHOST][:, at], whole[1][changed:], equal_nan=True), name
    trace = next(t for p in machine.describe()["plots"] for t in p["traces"] if t["role"] == "error")
    figures = machine.state()["figures"]
    for found, tail in ((again, ""), (alone, "_ghost")):
        error = found.signals[trace["signal"]][changed:] * trace["factor"]
        assert figures[f"rms{tail}"] == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)
        assert figures[f"worst{tail}"] == np.abs(error).max()


@pytest.mark.slow
def test_a_value_that_the_loop_cannot_compute_with_is_refused_and_the_machine_runs_on(tmp_path):
    machine = begun(tmp_path, "sofnn_tangent")
    did(machine, "start")
    before = machine._here().values()["sensor.trailing_s"]
    with pytest.raises(ValueRefused, match=r"^trailing_s = 1e\+308 .*expected 63 or fewer"):
        did(machine, "set", changes={"sensor.trailing_s": 1e308})
    assert machine.running == "running" and machine._here().values()["sensor.trailing_s"] == before
    ran(machine, 10)


@pytest.mark.parametrize("error", [OverflowError("inf"), ZeroDivisionError("0"), ValueError("nan"), IndexError("63")])
def test_what_a_block_did_not_foresee_in_a_value_is_a_refusal_that_names_the_value(error):
    def act():
        raise error

    with pytest.raises(
        ValueRefused, match=rf"^controller\.kp = 1e\+308: the machine cannot compute with it \({error}\)"
    ):
        sim_machine._obeyed("set", {"changes": {"controller.kp": 1e308}}, act)
    with pytest.raises(NameUnknown, match="as it was said"):
        sim_machine._obeyed("set", {}, lambda: (_ for _ in ()).throw(NameUnknown("as it was said")))
