"""What an operator does on each of the five machines, in a real browser, and what must come of it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from tests.panel.browser.chrome import Browsers, View
from tests.panel.served import Served

pytestmark = pytest.mark.slow

Rows = dict[str, np.ndarray]


@dataclass(frozen=True)
class Case:
    """One machine: what is changed while it runs, and what the plotted signal must show."""

    study: str
    key: str
    value: float
    signal: str
    seconds: float
    """Of simulated time until the effect is complete."""
    seen: Callable[[np.ndarray, np.ndarray, np.ndarray], bool]
    """Of the signal before the change, its last second, and that of a controller's previous setting."""
    controller: str
    trigger: tuple[str, float]
    """Signal and level in the shown unit, which it passes again and again or after a disturbance."""
    format: str
    speed: float = 1.0


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


CASES = (
    Case(
        "vud_lathe", "reference.target", 20.0, "actual.position", 3.0,
        lambda before, now, ghost: abs(before[-1] + 50) < 0.1 and abs(now[-1] - 20) < 0.1,
        "ours.vud_opt", ("actual.position", 10.0), "mat",
    ),
    Case(
        "grey_turning", "reference.force", 100.0, "actual.force", 4.0,
        lambda before, now, ghost: abs(before[-1] - 150) < 5 and abs(now.mean() - 100) < 5,
        "corrected.tfc_s6", ("actual.force", 120.0), "csv",
    ),
    Case(
        "fsmc_ballscrew", "reference.amplitude", 0.5, "actual", 1.2,
        lambda before, now, ghost: abs(np.ptp(before) - 2.0) < 0.02 and abs(np.ptp(now) - 1.0) < 0.02,
        "ours.pd_dob", ("command.position", 0.1), "parquet", 0.5,
    ),
    Case(
        "sofnn_tangent", "controller.max_offset", 1.0, "output", 2.0,
        lambda before, now, ghost: np.abs(before).max() > 3 and np.abs(now).max() <= 1.0 < np.abs(ghost).max(),
        "corrected.fuzzy", ("actual.deviation", 0.5), "parquet",
    ),
    Case(
        "npid_xytable", "controller.kp", 0.33, "true_error", 2.0,
        lambda before, now, ghost: rms(now) > 1.5 * rms(ghost),
        "paper.pid", ("command", 0.5), "csv",
    ),
)  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.study)
def test_an_operator_runs_the_machine_and_its_script_gives_the_same_signals(
    case: Case, browsers: Browsers, served: Served, tmp_path: Path
) -> None:
    with browsers.view(served) as view:
        view.choose(case.study)
        view.page.select_option("#speed", f"{case.speed:g}")
        view.start()
        view.simulate(1.2)
        changed(case, view)
        explained(case, view)
        captured(case, view)
        switched(case, view)
        view.page.click("#hold")
        view.until("panel.state.running === 'held'")
        replayed(case, view, tmp_path)


def changed(case: Case, view: View) -> None:
    """The parameter's effect is in the rows that are drawn, and not in those of a controller's previous setting."""
    before = view.history(case.signal)[case.signal]
    at = view.js("() => panel.history.last")
    view.parameter(case.key, case.value)
    view.simulate(case.seconds)
    view.picture(f"{case.study}_changed")
    period_s = view.js("() => panel.machine.period_s")
    now, ghost = view.history(case.signal), view.history(case.signal, ghost=True)
    if case.key.startswith("controller."):
        assert ghost["period"][0] > at, "the previous setting runs on from the change only"
    else:
        assert not len(ghost["period"]), "another command is no setting to be compared"
    second = now["period"] > now["period"][-1] - 1.0 / period_s
    ghost_second = ghost["period"] > now["period"][-1] - 1.0 / period_s
    assert case.seen(before, now[case.signal][second], ghost[case.signal][ghost_second])


def explained(case: Case, view: View) -> None:
    """Why the controller does what it does: the rules that fire now, the sets, the phase plane."""
    view.show("why")
    expected = {"npid_xytable": [], "fsmc_ballscrew": ["phase"]}.get(case.study, ["rules", "sets"])
    assert set(expected) <= set(view.js("() => panel.machine.views"))
    if expected:
        view.js("() => panel.on('why', (message) => { window.why = message.views; })")
        view.until(f"window.why && {expected}.every((name) => name in window.why)", 10)
    if "rules" in expected:
        shares = view.js("() => window.why.rules.rules.map((rule) => rule.share)")
        assert shares == sorted(shares, reverse=True) and shares[0] > 0.0 and sum(shares) <= 1.0 + 1e-6
    view.picture(f"{case.study}_why")


def captured(case: Case, view: View) -> None:
    """A capture is triggered, saved, loaded and laid over: the same values to the last bit."""
    signal, level = case.trigger
    page = view.page
    view.show("scope")
    page.get_by_label("Signal", exact=True).select_option(signal)
    page.get_by_label("Level", exact=True).fill(str(level))
    page.get_by_label("Slope", exact=True).select_option("either")
    page.get_by_label("Length", exact=True).fill("0.6")
    page.get_by_role("button", name="Arm", exact=True).click()
    view.until("panel.state.scope.phase !== 'idle'")
    if case.study == "vud_lathe":
        view.js("() => panel.send('set', {changes: {'reference.target': -50}})")
    if case.study == "grey_turning":
        view.js("() => panel.send('set', {changes: {'reference.force': 150}})")
    view.until("panel.state.scope.phase === 'done' && panel.captures.size > 0", 60)
    taken = view.js(CAPTURE, {"signal": signal, "which": -1})
    row, factor = taken["trigger_row"], view.js(FACTOR, signal)
    before, here = (taken["values"][row - 1] * factor, taken["values"][row] * factor)
    assert min(before, here) <= level <= max(before, here)
    page.get_by_label("Save as", exact=True).fill(f"{case.study} step")
    page.get_by_label("Format", exact=True).select_option(case.format)
    page.get_by_role("button", name="Save capture").click()
    name = f"{case.study} step.{case.format}"
    page.get_by_label("Saved captures").locator(f"option[value='{name}']").wait_for(state="attached", timeout=20_000)
    page.get_by_label("Saved captures").select_option(name)
    page.get_by_role("button", name="Overlay", exact=True).click()
    page.locator(".scope-captures li").nth(1).wait_for(timeout=20_000)
    view.picture(f"{case.study}_scope")
    assert view.js(SAME), "the overlay is the capture, to the last bit"
    view.show("live")


CAPTURE = """({signal, which}) => {
    const c = [...panel.captures.values()].at(which), width = c.values.length / c.rows, at = c.columns.indexOf(signal);
    return {trigger_row: c.trigger_row, values: Array.from({length: c.rows}, (_, i) => c.values[i * width + at])};
}"""
FACTOR = """(signal) => panel.machine.plots.flatMap((p) => p.traces).find((t) => t.signal === signal)?.factor ?? 1"""
SAME = """() => {
    const [a, b] = [...panel.captures.values()].slice(-2), bits = (c) => new BigUint64Array(c.values.slice().buffer);
    const [x, y] = [bits(a), bits(b)];
    return a.id !== b.id && a.rows === b.rows && a.trigger_row === b.trigger_row && `${a.columns}` === `${b.columns}`
        && x.length === y.length && x.every((v, i) => v === y[i]);
}"""


def switched(case: Case, view: View) -> None:
    """Another controller takes over while the machine runs on."""
    before = view.js("() => panel.state.period")
    view.page.select_option("#choose-controller", case.controller)
    view.until(f"panel.machine.controller === '{case.controller}'", 20)
    view.until(f"panel.state.running === 'running' && panel.state.period > {before}")
    view.simulate(0.5)
    view.picture(f"{case.study}_switched")
    gaps = np.diff(view.history()["period"])
    assert gaps.max() <= 2 * gaps.min(), "no row is missing on the page over the switch"


def replayed(case: Case, view: View, folder: Path) -> None:
    """The script says that it is identical, and its signals are those that the page drew."""
    with view.page.expect_download(timeout=30_000) as download:
        view.page.get_by_role("link", name="Script", exact=True).click()
    script = folder / "session.py"
    download.value.save_as(script)
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0 and "identical" in done.stdout, done.stdout + done.stderr
    with view.page.expect_download(timeout=30_000) as download:
        view.page.get_by_role("link", name="Experiment file", exact=True).click()
    session = folder / "session.toml"
    download.value.save_as(session)
    compared(view, session, case.signal)


def compared(view: View, session: Path, signal: str) -> None:
    """The rows on the page against those of the session run again here, as float32 as they are sent."""
    from leadscrew.operate import session_file

    again = session_file.read(session).run(record=[signal])
    assert again.identical
    rows = view.history(signal)
    assert len(rows["period"]) > 100 and rows["period"][-1] == len(again.signals[signal]) - 1
    expected = again.signals[signal].astype(np.float32)[rows["period"].astype(int)]
    assert np.array_equal(rows[signal].astype(np.float32), expected, equal_nan=True)
