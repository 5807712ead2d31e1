"""What the Scope, Why and Log views compute, run by node: cursor figures, zoom, trails, words, filters."""

import json
import math
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import leadscrew.panel
from tests.tools import missing

WEB = Path(leadscrew.panel.__file__).parent / "web"


def in_node(script: str, given: Any = None) -> Any:
    """What ``script`` says as JSON with ``say(value)``; ``given`` is there as such. NaN is "NaN"."""
    if shutil.which("node") is None:
        missing("node", "node is not installed")
    head = (
        f"const from = (file) => import({json.dumps(WEB.as_uri() + '/')} + file);\n"
        "const say = (v) => console.log(JSON.stringify(v, (k, x) => Number.isNaN(x) ? 'NaN' : x));\n"
        f"const given = {json.dumps(given)};\n"
    )
    done = subprocess.run(
        ["node", "--input-type=module", "--no-warnings", "-"],
        input=head + script, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def noisy() -> np.ndarray:
    return np.random.default_rng(3).normal(0.2, 1.0, 5000)


def test_figures_between_the_cursors_are_those_of_numpy(noisy: np.ndarray) -> None:
    script = (
        "const m = await from('measure.js'); say([m.statistics(given, 700, 4100), m.statistics(given, 4100, 700)]);"
    )
    forward, backward = in_node(script, noisy.tolist())
    part = noisy[700:4101]
    assert forward == backward
    assert forward["count"] == 3401
    assert forward["min"] == part.min() and forward["max"] == part.max()
    assert forward["mean"] == pytest.approx(part.mean(), rel=1e-12)
    assert forward["rms"] == pytest.approx(math.sqrt(np.mean(part**2)), rel=1e-12)


def test_a_value_that_is_missing_in_a_log_does_not_spoil_the_figures() -> None:
    script = "const m = await from('measure.js'); say([m.statistics([1, NaN, 3], 0, 2), m.statistics([NaN], 0, 0)]);"
    some, none = in_node(script)
    assert some == {"count": 2, "min": 1, "max": 3, "mean": 2, "rms": pytest.approx(math.sqrt(5))}
    assert none["count"] == 0 and none["mean"] == "NaN"


def test_cursors_read_the_sample_nearest_to_their_time_in_a_capture_that_was_moved() -> None:
    script = """const m = await from('measure.js');
    const c = { rows: 11, period_s: 0.001, trigger_row: 4 }, v = Array.from({ length: 11 }, (_, i) => i * i);
    say([m.rowAt(c, 0), m.rowAt(c, -1), m.rowAt(c, 0.0024), m.timeOf(c, 10), m.reading(c, v, -0.004, 0.002),
      [...m.times(c, 0.5)]]);"""
    at_zero, before, near, end, read, times = in_node(script)
    assert (at_zero, before, near, end) == (4, 0, 6, 0.006)
    assert (read["a"], read["b"], read["difference"], read["max"]) == (0, 36, 36, 36)
    assert times == pytest.approx([0.5 + 0.001 * (k - 4) for k in range(11)])


def test_zoom_keeps_the_place_under_the_mouse_and_never_leaves_the_capture() -> None:
    script = """const m = await from('measure.js'); const all = [-1, 3];
    say([m.zoomed([0, 2], 0.5, 0.5, all), m.zoomed([-1, 3], 2.9, 0.1, all), m.zoomed([0, 2], 1, 100, all),
      m.panned([0, 2], 9, all),
         m.panned([0, 2], -9, all), m.zoomed([0, 2], 1, 1e-9, all, 0.01)]);"""
    half, edge, out, right, left, least = in_node(script)
    assert half == [0.25, 1.25] and (0.5 - half[0]) / (half[1] - half[0]) == 0.25
    assert -1 <= edge[0] < edge[1] <= 3 and edge[1] - edge[0] == pytest.approx(0.4)
    assert out == [-1, 3] and right == [1, 3] and left == [-1, 1]
    assert least[1] - least[0] == pytest.approx(0.01)


def test_signals_of_one_unit_share_a_lane_and_a_plotted_one_keeps_its_shown_unit() -> None:
    script = """const e = await from('scope_entries.js'), m = await from('measure.js');
    const machine = { columns: [{ name: "error", unit: "mm" }, { name: "command", unit: "mm" },
      { name: "u", unit: "V" }],
      plots: [{ title: "", unit: "um",
        traces: [{ signal: "error", label: "error", role: "error", factor: 1000, unit: "um" }] }] };
    const capture = { id: 1, name: "old", columns: ["time", "error", "torque"], units: { error: "mm", torque: "N m" },
      rows: 2, period_s: 1,
      trigger_row: 0, values: Float64Array.from([0, 0.001, 5, 1, 0.002, 6]) };
    const entry = new e.Entry(capture), all = e.signalsOf(machine, [entry]);
    say([m.lanes(all).map((l) => [l.unit, l.signals.map((s) => s.signal)]), [...entry.values(all[0])],
      entry.values(all[1]),
         entry.values({ signal: "torque", own: "V", factor: 1 })]);"""
    lanes, error, absent, other = in_node(script)
    assert lanes == [["um", ["error"]], ["mm", ["command"]], ["V", ["u"]], ["N m", ["torque"]]]
    assert error == {"0": 1, "1": 2} or error == [1, 2]
    assert absent is None
    assert other is None, "a torque in N m was drawn as if it were V"


def test_an_overlay_stays_dashed_when_the_next_capture_takes_the_place_of_the_first() -> None:
    script = """const { Entries } = await from('scope_entries.js');
    const make = (id) => ({ id, name: `c${id}`, columns: ["a"], units: {}, rows: 3, period_s: 0.5, trigger_row: 1,
      values: new Float64Array(3) });
    const all = new Entries();
    all.lay(make(1)); all.lay(make(2)); all.lay(make(2)); all.keep(); all.keep(); all.take(make(3));
      all.overlays[0].shift = 0.25;
    say([all.main.id, all.overlays.map((o) => o.id), all.overlays.every((o) => o.dash.length > 0),
      all.overlays[0].dash !== all.overlays[1].dash,
         all.main.dash, all.extent()]);"""
    main, overlays, dashed, apart, solid, extent = in_node(script)
    assert (main, overlays, dashed, apart, solid) == (3, [2, 1], True, True, None)
    assert extent == [-0.5, 0.75]


def test_times_and_frequencies_are_written_in_the_unit_that_fits() -> None:
    script = """const f = await from('format.js');
    say([f.duration(0.0123), f.duration(-2.5), f.duration(0.00025), f.duration(0), f.frequency(0.05),
      f.frequency(1e-4), f.frequency(0)]);"""
    assert in_node(script) == ["12.3 ms", "-2.5 s", "250 µs", "0 s", "20 Hz", "10 kHz", "-"]


def test_the_log_is_searched_by_every_word_and_refused_tries_are_found() -> None:
    entries = [
        {"who": "Ann", "what": "set", "key": "controller.kp", "old": 1.0, "new": 2.0, "ok": True, "error": ""},
        {"who": "Bob", "what": "set", "key": "controller.kp", "old": None, "new": 9, "ok": False, "error": "too large"},
    ]
    script = """const a = await from('audit.js'); const who = (l) => l.map((e) => e.who);
    say([who(a.matching(given, "kp ann")), who(a.matching(given, "REFUSED")), who(a.matching(given, "", true)),
      who(a.matching(given, "kd")),
         who(a.newestFirst([{ at: "2026-01-01", who: "old" }, { at: "2026-01-02", who: "new" }]))]);"""
    assert in_node(script, entries) == [["Ann"], ["Bob"], ["Bob"], [], ["new", "old"]]


def test_the_polar_plot_puts_the_perfect_circle_on_its_ring_and_enlarges_only_the_deviation() -> None:
    script = """const c = await from('why_circle.js');
    say(c.polar([[0, 0], [90, 10], [180, -5], [270, 0]], [200, 200], 100, 20, 10));"""
    points = in_node(script)
    assert points == [pytest.approx(p, abs=1e-9) for p in ([300, 200], [200, 80], [110, 200], [200, 300])]


def test_the_trail_of_the_phase_plane_is_made_of_the_columns_that_the_controller_uses() -> None:
    script = """const { trailOf } = await from('why_phase.js'), { History } = await from('history.js');
    const history = new History(["position", "speed"], 1024), rows = 500, values = new Float32Array(2 * rows);
    for (let i = 0; i < rows; i++) { values[2 * i] = i; values[2 * i + 1] = -i; }
    history.push(0, 1, rows, values);
    const view = { x: { terms: [["position", 2], ["speed", 1]] }, y: { terms: [["speed", 1]] } };
    say([trailOf({ history, machine: { period_s: 0.001 } }, view, 0.1),
      trailOf({ history, machine: { period_s: 0.001 } }, { x: { terms: [["gone", 1]] }, y: view.y })]);"""
    trail, without = in_node(script)
    assert trail == [[float(i), float(-i)] for i in range(399, 500)]
    assert without is None


def test_the_trail_of_rows_that_came_as_least_and_greatest_pairs_is_as_wide_as_the_chatter() -> None:
    script = """const { trailOf } = await from('why_phase.js'), { History } = await from('history.js');
    const history = new History(["position", "speed"], 1024), pairs = 100, values = new Float32Array(4 * pairs);
    for (let i = 0; i < pairs; i++) values.set([i - 0.5, -i - 2, i + 0.5, -i + 2], 4 * i);
    history.push(0, 4, 2 * pairs, values);
    const view = { x: { terms: [["position", 1]] }, y: { terms: [["speed", 1]] } };
    say(trailOf({ history, machine: { period_s: 0.001 } }, view, 0.4));"""
    trail = in_node(script)
    expected = [[float(i), float(-i + side)] for i in range(50, 100) for side in (-2, 2)]
    assert trail[1:] == expected, "the first row is the second of its pair"


def test_what_the_trigger_waits_for_is_said_in_the_unit_on_the_screen() -> None:
    script = """const { words } = await from('scope_trigger.js');
    const signals = [{ signal: "error", label: "error", factor: 1000, unit: "um" }];
    const trigger = { signal: "error", level: 0.002, slope: "rising" };
    say([words({ phase: "armed", trigger, count: 2 }, signals),
      words({ phase: "idle", trigger: null, count: 0 }, signals), words({}, signals)]);"""
    armed, idle, nothing = in_node(script)
    assert "error to rise through 2 µm" in armed and "2 taken" in armed
    assert "arm" in idle and "not ready" in nothing
