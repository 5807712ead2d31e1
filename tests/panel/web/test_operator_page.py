"""The page as an operator stands before it: process values, tolerances, contrast, touch, keys; in a real browser."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.panel.browser.chrome import Browsers, View, browsers, served
from tests.panel.served import Served

pytestmark = pytest.mark.slow

__all__ = ["browsers", "served"]

READOUTS = """() => Object.fromEntries([...document.querySelectorAll(".readouts div")].map((box) =>
    [box.querySelector("span").textContent, Number(box.querySelector("output").textContent)]))"""

SEEN = """() => {
    const rgb = (text) => text.match(/[\\d.]+/g).map(Number);
    const ground = (element) => {
        for (let e = element; e; e = e.parentElement) {
            const [r, g, b, a = 1] = rgb(getComputedStyle(e).backgroundColor);
            if (a > 0.5) return [r, g, b];
        }
        return [255, 255, 255];
    };
    const found = [], walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walk.nextNode()) {
        const element = walk.currentNode.parentElement, text = walk.currentNode.textContent.trim();
        if (!text || !element.getClientRects().length || element.closest("script, option, select, .skip")) continue;
        const style = getComputedStyle(element);
        if (style.visibility === "hidden" || style.display === "none") continue;
        found.push({ text: text.slice(0, 30), off: Boolean(element.closest(":disabled")),
            px: parseFloat(style.fontSize), ink: rgb(style.color).slice(0, 3), ground: ground(element) });
    }
    return found;
}"""

PRESSED = "#run-buttons button, #control, #speed, #tabs button, #undo, #redo, .card button, #pause, #options, #help"


def contrast(ink: list[float], ground: list[float]) -> float:
    def luminance(colour: list[float]) -> float:
        parts = np.array(colour) / 255.0
        return float(np.dot([0.2126, 0.7152, 0.0722], np.where(parts <= 0.03928, parts / 12.92,
                                                               ((parts + 0.055) / 1.055) ** 2.4)))  # fmt: skip

    light, dark = sorted((luminance(ink), luminance(ground)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def running(view: View, study: str, seconds: float) -> None:
    view.choose(study)
    view.start()
    view.simulate(seconds)


def axis(view: View, plot: int) -> tuple[float, float]:
    low, high = view.js("(i) => [panel.live.plots[i].shown.min, panel.live.plots[i].shown.max]", plot)
    return low, high


def test_force_spindle_speed_and_depth_stand_above_the_plots_and_follow_what_is_done(
    browsers: Browsers, served: Served
) -> None:
    with browsers.view(served) as view:
        running(view, "grey_turning", 3.0)
        assert view.js("() => document.querySelector('.readouts').offsetHeight") <= 44
        shown = view.js(READOUTS)
        assert shown["set force"] == 150.0 and shown["spindle"] == 1200.0 and shown["depth of cut"] == 1.0
        assert abs(shown["force"] - 150.0) < 3.0
        assert shown["feed per rev"] == pytest.approx(shown["feed rate"] / 1200.0, rel=0.03)
        for field in view.js("() => [...document.querySelectorAll('.readouts div')].map((e) => e.offsetLeft)"):
            assert 0 <= field < 1280
        view.js("() => panel.send('disturb', {name: 'spindle_speed', fields: {rpm: 1000, for_s: 0}})")
        view.js("() => panel.send('disturb', {name: 'depth_step', fields: {step: -0.2, for_s: 0}})")
        view.until("panel.state.changed['plant.spindle_rpm'] === 1000")
        view.simulate(1.0)
        shown = view.js(READOUTS)
        assert shown["spindle"] == 1000.0 and shown["depth of cut"] == 0.8


def test_a_tolerance_that_a_large_move_hides_is_shown_by_a_key_and_stays_when_plots_are_built_anew(
    browsers: Browsers, served: Served
) -> None:
    with browsers.view(served) as view:
        running(view, "vud_lathe", 2.0)
        low, high = axis(view, 1)
        assert high - low > 1e4, "the step of 50 mm: +-2 um are less than a pixel"
        view.js("() => document.querySelector('.plot:nth-child(2) .tolerance').focus()")
        view.page.keyboard.press("Enter")
        view.page.wait_for_timeout(200)
        assert axis(view, 1) == (-6.0, 6.0)
        assert view.page.get_attribute(".plot:nth-child(2) .tolerance", "aria-pressed") == "true"
        view.page.select_option("#further", "plant.pwm")
        view.page.click(".plot:nth-child(1) .title")
        view.page.wait_for_timeout(200)
        assert axis(view, 1) == (-6.0, 6.0)
        view.page.click(".plot:nth-child(2) .tolerance")
        view.page.wait_for_timeout(200)
        assert axis(view, 1) != (-6.0, 6.0)


@pytest.mark.parametrize("run", [False, True])
def test_every_text_is_12_px_or_more_and_told_from_its_ground(browsers: Browsers, served: Served, run: bool) -> None:
    with browsers.view(served) as view:
        view.choose("vud_lathe")
        if run:
            view.start()
            view.simulate(0.5)
            view.js("() => panel.send('set', {changes: {'controller.error_full_scale_mm': 180}})")
        for tab in ("live", "scope", "why"):
            view.show(tab)
            view.page.wait_for_timeout(600)
            texts: list[dict[str, Any]] = view.js(SEEN)
            assert len(texts) > 50
            for found in texts:
                assert found["px"] >= 12.0, found
                assert found["off"] or contrast(found["ink"], found["ground"]) >= 4.5, found


def test_main_controls_can_be_pressed_with_a_finger_and_reached_in_their_order_by_tab(
    browsers: Browsers, served: Served
) -> None:
    with browsers.view(served, reduced_motion="reduce", has_touch=True) as view:
        running(view, "npid_xytable", 0.2)
        boxes = view.js(
            "(s) => [...document.querySelectorAll(s)].filter((e) => e.offsetHeight).map((e) => [e.id, e.offsetHeight])",
            PRESSED,
        )
        assert len(boxes) > 15
        assert all(height >= 40 for _, height in boxes), boxes
        view.js("() => document.querySelector('.skip').focus()")
        order = []
        for _ in range(80):
            view.page.keyboard.press("Tab")
            order.append(view.js("() => document.activeElement.id || document.activeElement.className"))
        wanted = ("control", "hold", "stop", "reset", "speed", "help", "search", "tab-live")
        places = [order.index(name) for name in wanted if name in order]
        assert len(places) >= 7 and places == sorted(places), order
        assert "start" not in order, "what cannot be pressed is passed over"
