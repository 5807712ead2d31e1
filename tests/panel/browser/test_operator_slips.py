"""What goes wrong at a machine and must be survived by the page: a second tab, a strange log, a run that is lost."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import pytest

from leadscrew.cli.panel import _open
from tests.panel.browser.chrome import Browsers
from tests.panel.served import Served

pytestmark = pytest.mark.slow


def test_a_duplicated_tab_watches_and_leaves_control_where_it_is(browsers: Browsers, served: Served) -> None:
    with browsers.view(served) as view:
        view.in_control()
        with view.page.expect_popup() as opened:
            view.js("() => { window.open(location.href); }")  # copies this tab's memory, as "Duplicate" does
        other = opened.value
        copied = "() => sessionStorage.getItem('leadscrew.secret')"
        for _ in range(600):  # until the other page has loaded and noticed
            if other.evaluate(copied) not in (None, view.js(copied)):
                break
            other.wait_for_timeout(100)
        assert other.evaluate(copied) and other.evaluate(copied) != view.js(copied)
        assert not other.evaluate("() => panel.isWriter") and view.js("() => panel.isWriter")
        other.close()
        view.page.wait_for_timeout(500)
        assert view.js("async () => (await panel.send('speed', {value: 1})) && panel.isWriter")
        view.page.reload()
        view.until("window.panel?.machine && panel.isWriter", 60)


def test_a_log_of_another_program_is_seen_at_once_whatever_its_columns_are_called(
    browsers: Browsers, served: Served, tmp_path: Path
) -> None:
    log = tmp_path / "log (1).csv"
    rows = "".join(f"{k / 1000},{k % 7},{k % 5},{-k}\n" for k in range(500))
    log.write_text("time,constructor,__proto__,joint error\n" + rows)
    with browsers.view(served) as view:
        view.choose("grey_turning")
        view.start()
        view.simulate(1.0)
        view.show("scope")
        view.page.get_by_role("button", name="Force", exact=True).click()
        view.until("panel.captures.size > 0")
        view.page.get_by_label("File to overlay").set_input_files(str(log))
        view.page.locator(".scope-captures li").nth(1).wait_for(timeout=20_000)
        view.page.wait_for_timeout(300)
        told = view.page.inner_text(".scope-shelf .side-note")
        assert "none of the signals shown" in told and "constructor" in told
        assert view.page.get_by_role("row", name="constructor").count() >= 1
        view.page.click(".scope-picker summary")
        view.page.locator(".scope-boxes label").first.wait_for()
        assert view.page.locator(".scope-boxes label").count() > 10
        view.page.click(".scope-picker summary")
        view.picture("strange_log")
        with view.page.expect_download(timeout=20_000) as download:
            view.page.get_by_role("link", name="log _1_.csv").first.click()
        assert download.value.path().read_text() == log.read_text()


def test_a_run_that_is_lost_shows_how_and_its_notices_go_with_the_next_one(browsers: Browsers, served: Served) -> None:
    with browsers.view(served) as view:
        view.choose("fsmc_ballscrew")
        view.start()
        view.simulate(1.0)
        view.js("() => panel.tell('set', {changes: {'controller.lam': 1e6}})")
        view.until("panel.state.running === 'diverged'", 20)
        view.page.wait_for_timeout(2500)
        view.picture("lost")
        for low, high in view.js("() => panel.live.plots.filter((p) => p.plot).map((p) => [p.shown.min, p.shown.max])"):
            assert high - low < 1e9, "the scale is not that of the last period"
        assert view.page.locator("#undo").is_disabled(), "only a reset is possible now"
        view.js("() => panel.tell('set', {changes: {'controller.lam': 1e7}})")  # refused: a notice
        view.until("document.querySelectorAll('.notice').length > 0", 5)
        box = "(s) => { const b = document.querySelector(s).getBoundingClientRect(); return [b.top, b.bottom]; }"
        assert view.js(box, "#notices")[0] >= view.js(box, "main")[1] - 1, "a notice hides nothing"
        view.page.wait_for_timeout(2500)
        view.page.click("#reset")
        view.until("panel.state.running === 'stopped'")
        view.start()
        view.simulate(0.3)
        assert view.page.locator(".notice.error").count() == 0


def test_hold_then_why_then_another_controller_shows_the_new_one_as_soon_as_it_runs(
    browsers: Browsers, served: Served
) -> None:
    with browsers.view(served) as view:
        view.choose("vud_lathe")
        view.start()
        view.simulate(0.3)
        view.page.click("#hold")
        view.until("panel.state.running === 'held'")
        view.show("why")
        view.page.select_option("#choose-controller", "ours.vud_fast")
        view.until("panel.machine.controller === 'ours.vud_fast'")
        view.page.wait_for_timeout(500)
        assert "cannot be shown" not in view.page.inner_text("#notices")
        view.start()
        view.page.locator(".why-cards tr, .why-cards li, .why-cards canvas, .why-cards svg").first.wait_for()
        view.until("panel.state.t > 0.5")
        assert "cannot be shown" not in view.page.inner_text("#notices")


def test_after_the_link_the_address_is_clean_and_a_reload_and_a_second_tab_are_let_in(
    browsers: Browsers, served: Served
) -> None:
    with browsers.view(served) as view:
        assert view.page.url == f"http://{served.address}/"
        assert view.js("() => document.cookie") == "", "no script of the page sees it"
        view.page.reload()
        view.until("window.panel?.machine && panel.connected")
        other = view.page.context.new_page()
        other.goto(f"http://{served.address}/")
        for page in (view.page, other):
            assert page.evaluate("() => performance.getEntriesByType('navigation')[0].name") == view.page.url
        assert other.evaluate("async () => (await fetch('api/captures/none.csv')).status") == 404
        view.wrong.clear()  # that answer is an error at the console
    with browsers.context() as stranger:
        page = stranger.new_page()
        assert "open the link that leadscrew panel printed" in page.goto(f"http://{served.address}/").text()


def test_a_browser_that_is_opened_by_a_file_with_the_link_is_let_in(
    browsers: Browsers, served: Served, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(webbrowser, "open", lambda address: True)
    _open(served.link, tmp_path / "open.html")
    with browsers.context() as own:
        page = own.new_page()
        page.goto((tmp_path / "open.html").as_uri())
        page.locator("#badge:text('SIMULATED')").wait_for()
        assert page.url == f"http://{served.address}/"


def test_a_page_of_an_earlier_panel_says_that_there_is_another_link(browsers: Browsers, tmp_path: Path) -> None:
    panel = Served(tmp_path, "vud_lathe")
    try:
        with browsers.view(panel) as view:
            view.page.context.clear_cookies()
            view.js("() => panel.drop()")
            view.page.locator("#refused[open]").wait_for()
            assert "open the link that leadscrew panel printed" in view.page.inner_text("#refused")
            view.page.context.new_page().goto(panel.link)
            view.page.click("#refused button")
            view.until("panel.connected && !document.querySelector('#refused').open")
            view.wrong.clear()  # the refusals
    finally:
        panel.end()


def test_with_a_token_files_are_fetched_without_it_in_the_address(browsers: Browsers, tmp_path: Path) -> None:
    token = tmp_path / "token"
    token.write_text("a-token-of-the-test-0123456789\n")
    panel = Served(tmp_path / "home", "--token-file", str(token))
    try:
        with browsers.view(panel) as view:
            asked: list[str] = []
            view.page.on("request", lambda request: asked.append(request.url))
            view.page.goto(f"http://{panel.address}/")
            view.until("window.panel?.machine && panel.connected")
            view.choose("vud_lathe")
            view.start()
            view.simulate(0.3)
            with view.page.expect_download(timeout=20_000) as download:
                view.page.get_by_role("link", name="Script", exact=True).click()
            assert "vud_lathe" in download.value.path().read_text()
            links = view.js("() => [...document.querySelectorAll('a')].map((a) => a.href)")
            assert links and not any("0123456789" in address for address in [*links, *asked])
    finally:
        panel.end()


def test_lists_at_the_top_begin_with_what_an_operator_knows(browsers: Browsers, served: Served) -> None:
    with browsers.view(served) as view:
        view.in_control()
        for study in view.js("() => panel.machine.studies"):
            words = view.js("(n) => document.querySelector(`#choose-study option[value='${n}']`).text", study["name"])
            assert words.startswith(study["title"])
        speeds = view.js("() => [...document.querySelectorAll('#speed option')].map((o) => Number(o.value))")
        assert (min(speeds), max(speeds)) == (0.001, 20)
        assert view.page.get_attribute("#choose-study", "title")
