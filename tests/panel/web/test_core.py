"""What the live page keeps and computes, run by node: frames, rings, buckets of pixels, axes, numbers, sliders."""

import base64
import math
from typing import Any

import numpy as np
import pytest

from leadscrew.panel.frames import LIVE, Frame, Thinner
from tests.panel.web.test_views import in_node

DECODED = """
const { frameOf } = await from('connection.js');
const bytes = (text) => Uint8Array.from(Buffer.from(text, 'base64')).buffer;
"""
CUT = """
const { History } = await from('history.js'), { Buckets } = await from('decimate.js');
const push = (history, first, rows) => history.push(first, 1, rows.length, Float32Array.from(rows.flat()));
const fed = (buckets, cuts) => {
  let at = 0;
  for (const cut of cuts) {
    push(buckets.history, at, given.rows.slice(at, cut));
    if (at >= given.change) push(buckets.ghost, at, given.rows.slice(at, cut).map((r) => r.map((v) => v + 10)));
    buckets.update();
    at = cut;
  }
};
const held = (b) => Array.from({ length: b.made - b.oldest }, (_, i) => (b.oldest + i) % b.count);
const seen = (b) => held(b).map((at) => [b.ids[at], b.main[0].low[at], b.main[0].high[at],
  b.main[1].low[at], b.main[1].high[at], b.old[1].low[at], b.old[1].high[at]]);
"""


def test_the_page_reads_the_frames_that_the_server_writes() -> None:
    rows = np.random.default_rng(5).normal(size=(7, 3))
    text = base64.b64encode(Frame(LIVE, 4, 1234.0, 2.0, rows).encode()).decode()
    script = DECODED + "const f = frameOf(bytes(given)); say({ ...f, values: [...f.values] });"
    found = in_node(script, text)
    assert (found["kind"], found["run"], found["first"], found["stride"]) == (1, 4, 1234.0, 2.0)
    assert (found["rows"], found["columns"]) == (7, 3)
    assert np.array_equal(np.float32(found["values"]).reshape(7, 3), rows.astype(np.float32))


@pytest.mark.parametrize("cut", [0, 31, 40, 100])
def test_a_frame_that_was_cut_short_is_passed_over(cut: int) -> None:
    data = Frame(LIVE, 1, 0.0, 1.0, np.ones((9, 2))).encode()[:cut]
    assert in_node(DECODED + "say(frameOf(bytes(given)));", base64.b64encode(data).decode()) is None


def test_buckets_hold_least_and_greatest_of_each_pixel_however_the_rows_were_cut() -> None:
    rng = np.random.default_rng(11)
    rows = rng.normal(size=(2300, 2)).astype(np.float32).astype(float)
    cuts = np.unique(np.append(rng.integers(1, 2300, 60), [1000, 2300])).tolist()
    script = (
        CUT
        + """
    const ring = () => new History(['a', 'b'], 4096);
    const slow = new Buckets(ring(), ring(), [1, 0], 7, 200, 1000);
    const quick = new Buckets(ring(), ring(), [1, 0], 7, 200, 1000);
    fed(slow, given.cuts);
    fed(quick, [1000, 2300]);
    const first = seen(slow);
    slow.restart();
    say([first, seen(quick), seen(slow)]);
    """
    )
    slow, quick, again = in_node(script, {"rows": rows.tolist(), "cuts": cuts, "change": 1000})
    assert slow == quick == again
    assert len(slow) == 200 and slow[-1][0] == 2299 // 7
    for bucket, *found in slow:
        inside = np.arange(7 * int(bucket), min(7 * int(bucket) + 7, 2300))
        b, a = rows[inside, 1], rows[inside, 0]
        assert found[:4] == [b.min(), b.max(), a.min(), a.max()]
        ghost = (rows[inside[inside >= 1000], 0] + 10).astype(np.float32)
        assert found[4:] == ([ghost.min(), ghost.max()] if len(ghost) else ["NaN", "NaN"])


def test_pairs_of_a_fast_loop_show_every_peak_in_its_pixel() -> None:
    rows = np.random.default_rng(2).normal(size=(8000, 1))
    rows[[1234, 6001]] = [[50.0], [-60.0]]
    thinner = Thinner(LIVE, 1)
    thinner.pace(40000.0)
    frames = [f for at in range(0, 8000, 800) for f in thinner.feed(at, rows[at : at + 800])]
    text = [base64.b64encode(f.encode()).decode() for f in frames]
    script = (
        CUT
        + DECODED
        + """
    const history = new History(['a'], 4096), buckets = new Buckets(history, new History(['a'], 64), [0], 80, 100);
    for (const text of given.frames) {
      const f = frameOf(bytes(text));
      history.push(f.first, f.stride, f.rows, f.values);
    }
    buckets.update();
    say(held(buckets).map((at) => [buckets.main[0].low[at], buckets.main[0].high[at]]));
    """
    )
    found = np.array(in_node(script, {"frames": text, "rows": []}))
    expected = rows[:, 0].reshape(100, 80).astype(np.float32)
    assert np.array_equal(found, np.stack([expected.min(axis=1), expected.max(axis=1)], axis=1))


def test_the_rings_keep_the_newest_rows_and_their_memory() -> None:
    script = (
        CUT
        + """
    const h = new History(['a', 'b'], 64), rings = [...h.data];
    push(h, 0, Array.from({ length: 50 }, (_, i) => [i, -i]));
    push(h, 40, Array.from({ length: 30 }, (_, i) => [40 + i, -40 - i])); // ten of them again, as after a lost line
    push(h, 200, [[200, -200]]);
    say({ size: h.size, oldest: h.period(h.oldest), tail: [...h.tail('b', 3)], gaps: h.gaps, last: h.last,
      same: rings.every((ring, i) => ring === h.data[i]), found: h.period(h.find(60.5)), none: h.value('c', 70) });
    """
    )
    found = in_node(script)
    assert found == {
        "size": 64, "oldest": 7, "tail": [-68, -69, -200], "gaps": [[69, 200]], "last": 200, "same": True, "found": 61,
        "none": "NaN",
    }  # fmt: skip


def test_a_switch_of_the_controller_keeps_the_signals_that_both_have() -> None:
    script = (
        CUT
        + """
    const h = new History(['a', 'b'], 64);
    push(h, 0, [[1, 2], [3, 4]]);
    h.keep(['c', 'b']);
    push(h, 2, [[5, 6]]);
    say([[...h.tail('b', 3)], [...h.tail('c', 3)]]);
    """
    )
    assert in_node(script) == [[2, 4, 6], ["NaN", "NaN", 5]]


def test_an_axis_shows_all_values_and_does_not_jitter() -> None:
    script = """
    const { Axis } = await from('decimate.js');
    const axis = new Axis();
    say(given.map(([low, high], i) => { axis.fit(low, high, 20 * i); return [axis.min, axis.max]; }));
    """
    rng = np.random.default_rng(8)
    wide = np.where(np.arange(600) < 200, 1.0, 0.01)
    ranges = np.stack([-wide * (1 + 0.2 * rng.random(600)), wide * (1 + 0.2 * rng.random(600))], axis=1)
    found = np.array(in_node(script, ranges.tolist()))
    assert (found[:, 0] <= ranges[:, 0]).all() and (found[:, 1] >= ranges[:, 1]).all()
    assert len(np.unique(found, axis=0)) <= 5
    assert found[-1].max() < 0.05, "the axis did not close after the large values had left"


@pytest.mark.parametrize("low, high", [(5.0, 5.0), (0.0, 0.0), (1e-12, 2e-12), (-1e9, 1e9), (50.0, 50.0001)])
def test_an_axis_of_a_still_or_a_huge_signal_is_no_line(low: float, high: float) -> None:
    script = "const { Axis } = await from('decimate.js'); const a = new Axis().fit(...given, 0); say([a.min, a.max]);"
    bottom, top = in_node(script, [low, high])
    assert bottom < low and high < top and math.isfinite(top - bottom)


def test_a_value_that_is_shown_can_be_typed_back_without_loss() -> None:
    values = [0.1, 1.32, -2.5e-7, 440.00000000000006, 1e300, 5e-324, 3.0, -190.0, 123456789.123]
    script = "const f = await from('format.js'); say(given.map((v) => f.typed(f.exact(v))));"
    assert in_node(script, values) == values


@pytest.mark.parametrize(
    "text, value", [("1,5", 1.5), (" 12 000 ", 12000), ("1e-3", 1e-3), (".5", 0.5), ("1,2,3", None), ("0x10", None),
                    ("NaN", None), ("Infinity", None), ("1e400", None), ("", None), ("3 mm", None)],
)  # fmt: skip
def test_what_is_typed_is_a_number_or_nothing(text: str, value: float | None) -> None:
    found = in_node("say((await from('format.js')).typed(given));", text)
    assert found == ("NaN" if value is None else value)


PARAMETERS: list[dict[str, Any]] = [
    {"type": "float", "default": 1.32, "low": 0, "high": None},
    {"type": "float", "default": -90.0, "low": None, "high": None},
    {"type": "float", "default": 0.0, "low": None, "high": None},
    {"type": "float", "default": 0.7, "low": 0, "high": 2, "low_open": True},
    {"type": "float", "default": 0.3, "low": 0, "high": 1, "high_open": True},
    {"type": "float", "default": 3.5, "low": 0, "high": 1000, "low_open": True},
    {"type": "float", "default": 10.0, "low": 1, "high": 10000},
    {"type": "float", "default": 0.25, "low": 0, "high": 5000, "low_open": True},
    {"type": "int", "default": 4, "low": 0, "high": 12},
    {"type": "int", "default": 0, "low": 0, "high": None},
    {"type": "float", "default": 2.0, "low": 2.0, "high": None},
]


@pytest.mark.parametrize("parameter", PARAMETERS, ids=str)
def test_a_slider_gives_only_allowed_values_and_finds_the_default_again(parameter: dict[str, Any]) -> None:
    script = """
    const scale = (await from('slider.js')).scaleOf(given);
    const positions = Array.from({ length: 1001 }, (_, i) => i);
    say([positions.map(scale.value), scale.value(Math.round(scale.position(given.default)))]);
    """
    values, again = in_node(script, parameter)
    low, high = parameter["low"], parameter["high"]
    assert (np.diff(values) >= 0).all() and values[-1] > values[0]
    assert low is None or (values[0] > low if parameter.get("low_open") else values[0] >= low)
    assert high is None or (values[-1] < high if parameter.get("high_open") else values[-1] <= high)
    assert again == pytest.approx(parameter["default"], rel=0.01, abs=0.01 * (values[-1] - values[0]))
    assert parameter["type"] != "int" or all(v == int(v) for v in values)


def test_no_slider_stands_for_a_table_a_switch_or_a_value_that_means_never() -> None:
    given = [
        {"type": "array", "default": [1]},
        {"type": "bool", "default": True},
        {"type": "float", "default": 1e9, "low": 0},
    ]
    assert in_node("const s = await from('slider.js'); say(given.map(s.scaleOf));", given) == [None, None, None]
