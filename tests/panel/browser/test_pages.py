"""Several browsers before one machine, a connection that breaks, and the keyboard."""

from __future__ import annotations

import numpy as np
import pytest

from tests.panel.browser.chrome import Browsers, View
from tests.panel.served import Served

pytestmark = pytest.mark.slow

REFUSED = "async (what) => { try { await panel.send(...what); return ''; } catch (error) { return error.message; } }"

BREAKABLE = """
    window.sockets = [];
    const Real = WebSocket;
    window.WebSocket = class extends Real {
        constructor(url, names) { super(window.cut ? `${url}nowhere` : url, names); window.sockets.push(this); }
    };
"""
"""Lets a test break the page's connection, and keep it broken while ``cut`` is set."""


def running(view: View, study: str) -> None:
    view.choose(study)
    view.page.select_option("#speed", "1")
    view.start()
    view.simulate(0.5)


def test_of_two_browsers_one_writes_and_the_other_sees_it(browsers: Browsers, served: Served) -> None:
    with browsers.view(served) as ann:
        running(ann, "vud_lathe")
        with browsers.view(served) as bob:
            assert not bob.js("() => panel.isWriter")
            assert "you watch" in bob.page.inner_text("#writer").lower()
            for button in ("#start", "#hold", "#stop", "#reset"):
                assert bob.page.locator(button).is_disabled(), button
            before = ann.js("() => panel.state.period")
            for what in (
                ["stop"],
                ["set", {"changes": {"reference.target": 0}}],
                ["take"],
                ["machine", {"study": "npid_xytable"}],
            ):
                assert "has control" in bob.js(REFUSED, what), what
            bob.page.keyboard.press("Escape")
            ann.parameter("reference.target", 30)
            bob.until("panel.state.changed['reference.target'] === 30 && panel.state.t > 0")
            ann.simulate(2.0)
            seen, shown = ann.history("actual.position"), bob.history("actual.position")
            bob.picture("watching")
            assert ann.js("() => panel.state.period") > before and abs(shown["actual.position"][-1] - 30) < 0.1
            same = np.intersect1d(seen["period"], shown["period"], return_indices=True)
            assert len(same[0]) > 1000 and np.array_equal(
                seen["actual.position"][same[1]], shown["actual.position"][same[2]]
            )
            ann.page.click("#control")
            bob.until("panel.state.writer === null")
            bob.page.click("#control")
            bob.until("panel.isWriter")
            ann.until("!panel.isWriter")
            assert ann.page.locator("#stop").is_disabled() and bob.page.locator("#stop").is_enabled()
            entries = bob.js("async () => (await panel.send('audit', {last: 200})).entries")
            refused = [e for e in entries if not e["ok"]]
            assert {"stop", "set", "take", "machine"} <= {e["what"] for e in refused}
            change = next(e for e in entries if e["ok"] and e.get("key") == "reference.target")
            assert (change["old"], change["new"]) == (-50, 30)


def test_a_broken_connection_stops_nothing_and_loses_nothing(browsers: Browsers, served: Served) -> None:
    with browsers.view(served, script=BREAKABLE) as view:
        running(view, "npid_xytable")
        before = view.js("() => { window.cut = true; sockets.at(-1).close(); return panel.state.period; }")
        view.until("!panel.connected")
        assert view.page.locator("#stop").is_disabled() and "runs on" in view.page.inner_text("#banner")
        view.page.wait_for_timeout(2000)
        view.picture("connection_lost")
        view.js("() => { window.cut = false; }")
        view.until("panel.connected && panel.isWriter", 15)
        view.simulate(0.5)
        assert view.js("() => panel.state.period") - before > 2.0 / 0.0005
        periods = view.history()["period"]
        assert periods[0] == 0 and np.all(np.diff(periods) == 1), "every period is there, those of the gap too"
        view.parameter("controller.kp", 1.0)
        view.wrong.clear()  # Chromium notes every attempt to connect that failed.


def test_keys_start_hold_and_stop(browsers: Browsers, served: Served) -> None:
    with browsers.view(served) as view:
        view.choose("grey_turning")
        for key, state in (("s", "running"), ("h", "held"), ("s", "running"), ("Escape", "stopped")):
            view.page.locator("body").press(key)
            view.until(f"panel.state.running === '{state}'", 5)
