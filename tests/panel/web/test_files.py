"""What the page does with names, logs of other programs, its own secret and values that ran away; run by node."""

import re

from leadscrew.panel.downloads import is_capture_name
from tests.panel.web.test_views import WEB, in_node

ENTRY = """
const { Entry, Entries, overlaid, signalsOf } = await from('scope_entries.js');
const capture = (columns, units = {}) => ({ id: 1, name: "log", columns, units: JSON.parse(JSON.stringify(units)),
  rows: 2, period_s: 1, trigger_row: 0, values: Float64Array.from({ length: 2 * columns.length }, (_, i) => i) });
const machine = { columns: [{ name: "actual.force", unit: "N" }, { name: "error", unit: "mm" }], plots: [
  { title: "", unit: "N", traces: [{ signal: "actual.force", label: "force", role: "actual", factor: 1 }] },
  { title: "", unit: "um", traces: [{ signal: "error", label: "error", role: "error", factor: 1000, unit: "um" }] }] };
"""


def test_a_file_of_any_name_is_kept_under_one_that_the_server_takes() -> None:
    names = [
        "log (1).csv", "Stößel übersicht.CSV", "../../etc/passwd.csv", "..", ".hidden.mat", "a" * 90 + ".parquet",
        "测量.csv", "run 12.30.csv",
    ]  # fmt: skip
    found = in_node("const { kept } = await from('saved.js'); say(given.map(kept));", names)
    for name, cleaned in zip(names, found, strict=True):
        stem, _, suffix = name.rpartition(".")
        if stem.strip("."):
            assert is_capture_name(cleaned) or suffix != suffix.lower(), (name, cleaned)
            assert cleaned.endswith(f".{suffix}")
        assert re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,63}", cleaned) and ".." not in cleaned
    assert found[0] == "log _1_.csv" and found[-1] == names[-1]


def test_columns_called_like_parts_of_javascript_are_columns_without_a_unit() -> None:
    script = (
        ENTRY
        + """const names = ["constructor", "__proto__", "toString", "x"];
    const { unit } = await from('format.js');
    const entry = new Entry(capture(names, { x: "mm" })), all = signalsOf(machine, [entry]);
    say(all.slice(2).map((s) => [s.signal, unit(s.unit), entry.values(s) !== null]));"""
    )
    assert in_node(script) == [
        ["constructor", "", True], ["__proto__", "", True], ["toString", "", True], ["x", "mm", True],
    ]  # fmt: skip


def test_a_log_that_shares_no_shown_signal_is_shown_with_its_own_columns_and_that_is_said() -> None:
    script = (
        ENTRY
        + """const log = new Entry(capture(["joint.0.f-error", "b", "c", "d", "e"]));
    const all = signalsOf(machine, [log]), shown = all.slice(0, 2), none = overlaid(log, shown, all);
    const same = new Entry(capture(["error", "b"], { error: "mm" })), some = overlaid(same, shown, all);
    say([none, some]);"""
    )
    none, some = in_node(script)
    assert none["also"] == ["joint.0.f-error", "b", "c", "d"] and "none of the signals shown" in none["words"]
    assert some["also"] == [] and "dashed: error" in some["words"]


def test_a_column_named_as_the_plot_names_its_signal_lies_over_it_in_the_unit_shown() -> None:
    script = (
        ENTRY
        + """const all = signalsOf(machine, []), of = (...a) => new Entry(capture(...a));
    const um = { ...all[1], signal: "other" }; // labelled "error", shown in um
    say([of(["force"]).values(all[0]), of(["force"], { force: "kN" }).values(all[0]), of(["error"]).values(um),
      of(["error"], { error: "mm" }).values(um), of(["error"], { error: "um" }).values(um)].map((v) => v && [...v]));"""
    )
    force, other, plain, mm, um = in_node(script)
    assert force == [0, 1] and other is None
    assert plain == um == [0, 1] and mm == [0, 1000]


def test_a_duplicated_tab_gets_a_secret_of_its_own_and_a_reload_keeps_it() -> None:
    script = """const { ownSecret } = await from('secret.js');
    const store = (start) => { const held = new Map(start); return { held, getItem: (k) => held.get(k) ?? null,
      setItem: (k, v) => held.set(k, v) }; };
    const lines = [], line = () => { const own = new BroadcastChannel("test"); lines.push(own); return own; };
    const a = store(), first = await ownSecret(a, line());
    const duplicate = await ownSecret(store(a.held), line());
    for (const one of lines) one.close();
    const reload = await ownSecret(store(a.held), line());
    for (const one of lines) one.close();
    say([first, duplicate, reload]);"""
    first, duplicate, reload = in_node(script)
    assert re.fullmatch(r"[0-9a-f]{32}", first) and re.fullmatch(r"[0-9a-f]{32}", duplicate)
    assert first == reload != duplicate


def test_the_scale_is_that_of_the_signal_before_it_ran_away() -> None:
    script = """const { History } = await from('history.js'), { Buckets, usualLimit } = await from('decimate.js');
    const h = new History(['a'], 1024), v = Float32Array.from({ length: 400 }, (_, i) => Math.sin(i));
    v.set([1e4, 1e20, Infinity, NaN], 396);
    h.push(0, 1, 400, v);
    const b = new Buckets(h, new History(['a'], 64), [0], 4, 200), free = { low: 0, high: 0 };
    const shown = { low: 0, high: 0 };
    b.extent(b.main[0], 1, 0, free);
    b.extent(b.main[0], 1, 0, shown, usualLimit(b, b.main[0], 0));
    say([free, shown]);"""
    free, shown = in_node(script)
    assert 0.9 < -shown["low"] <= 1.0 and 0.9 < shown["high"] < 200
    assert free["high"] is not None, "infinity is no scale"


def test_no_address_of_the_page_holds_the_token() -> None:
    for script in WEB.glob("*.js"):
        assert "token=" not in script.read_text(encoding="utf-8"), script.name
