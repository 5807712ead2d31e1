"""The live page itself: what is typed, refused, undone, drawn and folded, in a real browser."""

from __future__ import annotations

import pytest

from tests.panel.browser.chrome import Browsers, View
from tests.panel.served import Served

pytestmark = pytest.mark.slow

KP = "#param-controller-kp"
ROW = ".param[data-key='controller.kp']"

COLOURED = """({plot, colour}) => {
    const canvas = document.querySelectorAll(".plot")[plot].querySelector("canvas");
    const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height), columns = new Set();
    for (let i = 0; i < data.length; i += 4) {
        if (colour.every((c, j) => Math.abs(data[i + j] - c) < 3) && data[i + 3] > 250) {
            columns.add((i / 4) % canvas.width);
        }
    }
    return [columns.size, canvas.width];
}"""
FEEDBACK = (0, 114, 178)


def begin(view: View, study: str) -> None:
    view.choose(study)
    view.start()
    view.simulate(0.5)


def test_a_refused_value_is_put_back_with_the_reason_beside_it(browsers: Browsers, served: Served) -> None:
    with browsers.view(served) as view:
        begin(view, "npid_xytable")
        none = "is not a finite number"
        for typed, reason in (("-5", "allowed range is [0, inf)"), ("1e400", none), ("much", none)):
            view.page.fill(KP, typed)
            view.page.press(KP, "Enter")
            view.until(f"document.querySelector(\"{ROW} .error\").textContent.includes('{reason}')", 5)
            assert view.page.input_value(KP) == "1.32"
        assert view.js("() => panel.state.changed['controller.kp']") is None
        view.page.fill(KP, "1,5")
        view.page.press(KP, "Enter")
        view.until("panel.state.changed['controller.kp'] === 1.5")
        assert view.page.inner_text(f"{ROW} .error") == "", "a decimal comma is understood"
        assert "1.32" in view.page.inner_text(f"{ROW} .mark"), "the default stands beside a changed value"
        view.page.locator("body").press("Control+z")
        view.until(f"document.querySelector('{KP}').value === '1.32'")


def test_an_option_is_chosen_from_a_list_of_names(browsers: Browsers, served: Served) -> None:
    field, row = "#param-controller-anti_windup", ".param[data-key='controller.anti_windup']"
    with browsers.view(served) as view:
        begin(view, "npid_xytable")
        assert view.js(f"() => [...document.querySelector('{field}').options].map((o) => o.text)") == [
            "none", "clamping", "back-calculation"
        ]  # fmt: skip
        assert view.page.input_value(field) == "clamping"
        view.page.select_option(field, "back-calculation")
        view.until("panel.state.changed['controller.anti_windup'] === 'back-calculation'")
        assert "default clamping" in view.page.inner_text(f"{row} .mark")
        view.page.click(f"{row} .mark")
        view.until(f"document.querySelector('{field}').value === 'clamping'")


def test_letters_typed_into_a_field_never_run_the_machine_and_escape_always_stops_it(
    browsers: Browsers, served: Served
) -> None:
    with browsers.view(served) as view:
        view.choose("npid_xytable")
        view.page.locator("#search").press_sequentially("shprs 123")
        view.page.wait_for_timeout(300)
        assert view.js("() => [panel.state.running, panel.view]") == ["stopped", "live"]
        view.page.fill("#search", "")
        view.start()
        view.page.fill(KP, "7")
        view.page.press(KP, "Escape")
        view.until("panel.state.running === 'stopped'", 5)
        assert view.js("() => panel.machine.parameters.find((p) => p.key === 'controller.kp').value") == 1.32
        assert view.page.input_value(KP) == "1.32"


def test_signals_are_drawn_in_their_colours_hidden_by_a_click_and_folded(browsers: Browsers, served: Served) -> None:
    with browsers.view(served) as view:
        begin(view, "npid_xytable")
        view.simulate(3.0)
        view.page.keyboard.press("p")
        view.page.wait_for_timeout(200)
        columns, width = view.js(COLOURED, {"plot": 0, "colour": FEEDBACK})
        assert columns > 0.7 * width, "the reading fills the window from left to right"
        view.page.click(".plot >> nth=0 >> .entry >> nth=2")
        view.page.wait_for_timeout(200)
        assert view.js(COLOURED, {"plot": 0, "colour": FEEDBACK})[0] < 5
        height = view.js("() => document.querySelectorAll('.plot canvas')[0].clientHeight")
        view.page.click(".plot >> nth=1 >> .title")
        view.page.wait_for_timeout(200)
        assert view.page.locator(".plot >> nth=1 >> canvas").count() == 0
        assert view.js("() => document.querySelectorAll('.plot canvas')[0].clientHeight") > height
        view.page.select_option("#further", "plant.position")
        view.until("document.querySelectorAll('.plot').length === panel.machine.plots.length + 1")
        assert view.js("() => document.documentElement.scrollHeight <= innerHeight"), "the page itself does not scroll"


def test_the_page_keeps_drawing_and_measures_when_a_change_is_seen(browsers: Browsers, served: Served) -> None:
    """Frames a second and milliseconds are rows of ``leadscrew bench --only panel``, read where this reads them."""
    with browsers.view(served) as view:
        begin(view, "vud_lathe")
        rates = []
        for i in range(12):
            view.js("(v) => panel.send('set', {changes: {'reference.target': v}})", -50.0 - i)
            view.page.wait_for_timeout(500)
            rates.append(view.js("() => panel.measures.fps"))
        times = view.js("() => panel.measures.latency_ms")
        assert len(times) == 12 and min(times) > 0.0
        assert min(rates) > 0.0
