"""The panel's page in a real browser: headless Chromium, driven by Playwright, before a real panel."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.panel.served import Served
from tests.tools import missing

PICTURES = Path(__file__).parents[3] / "build" / "panel"
"""Where screenshots are kept; an artefact of CI."""

LAPTOP = {"width": 1280, "height": 720}

HISTORY = """({names, ghost}) => {
    const held = ghost ? panel.ghostHistory : panel.history, out = {period: []};
    for (const name of names) out[name] = [];
    for (let i = held.oldest; i < held.serial; i += 1) {
        out.period.push(held.period(i));
        for (const name of names) out[name].push(held.value(name, i));
    }
    return out;
}"""


class View:
    """One page on a panel, as a person has it before them."""

    def __init__(self, page: Any, served: Served) -> None:
        self.page, self.served = page, served
        self.wrong: list[str] = []
        page.on("pageerror", lambda error: self.wrong.append(f"error in the page: {error}"))
        page.on("console", lambda said: self.wrong.append(said.text) if said.type == "error" else None)
        page.on("requestfailed", lambda request: self.wrong.append(f"not loaded: {request.url}"))
        page.goto(served.link)
        self.until("panel.machine && panel.state && panel.state.running !== 'building'")

    def js(self, expression: str, argument: Any = None) -> Any:
        """The value of an expression in the page, or of a function of one argument."""
        return self.page.evaluate(expression, argument)

    def until(self, expression: str, seconds: float = 120.0) -> Any:
        """Waits until an expression is true in the page; gives it. (The page's own rules forbid wait_for_function.)"""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if found := self.js(f"() => {expression}"):
                return found
            self.page.wait_for_timeout(25)
        state, notices = self.js("() => JSON.stringify(panel.state)"), self.page.inner_text("#notices")
        raise AssertionError(f"not within {seconds} s: {expression}; state {state}; notices {notices!r}; {self.wrong}")

    def history(self, *names: str, ghost: bool = False) -> dict[str, np.ndarray]:
        """Rows that the page holds and draws: their ``period`` and these signals."""
        return {k: np.array(v, dtype=float) for k, v in self.js(HISTORY, {"names": names, "ghost": ghost}).items()}

    def choose(self, study: str) -> None:
        """Another machine by the list at the top, in control."""
        self.in_control()
        if self.js("() => panel.machine.study") != study:
            self.page.select_option("#choose-study", study)
        self.until(f"panel.machine.study === '{study}' && panel.state.running === 'stopped'")

    def in_control(self) -> None:
        """Waits for control, which the first page takes by itself; asks for it where it does not."""
        self.until("panel.isWriter || panel.state.writer === null", 40)
        self.page.wait_for_timeout(300)
        if not self.js("() => panel.isWriter"):
            self.page.click("#control")
        self.until("panel.isWriter")

    def start(self) -> None:
        """Start, by its button."""
        self.page.click("#start")
        self.until("panel.state.running === 'running'")

    def simulate(self, seconds: float) -> None:
        """Waits for so much simulated time."""
        goal = self.js("() => panel.state.t") + seconds
        self.until(f"panel.state.t >= {goal}", 30.0 + 10.0 * seconds)

    def parameter(self, key: str, value: float | str) -> None:
        """Types a value into a parameter's field and waits until the machine has it."""
        self.page.fill("#search", key)
        field = "#param-" + key.replace(".", "-")
        self.page.fill(field, str(value))
        self.page.press(field, "Enter")
        self.until(f"panel.state.changed['{key}'] === {value}")
        self.page.fill("#search", "")

    def show(self, view: str) -> None:
        """One of the tabs: live, scope, why."""
        self.page.click(f"#tab-{view}")

    def picture(self, name: str) -> Path:
        """A screenshot under ``build/panel``."""
        PICTURES.mkdir(parents=True, exist_ok=True)
        self.page.wait_for_timeout(150)
        self.page.screenshot(path=str(PICTURES / f"{name}.png"))
        return PICTURES / f"{name}.png"

    def leave(self) -> None:
        """Stops the machine and gives control back, so that the next page finds it free."""
        if self.js("() => panel.isWriter && panel.connected"):
            self.js("async () => { await panel.tell('stop'); await panel.tell('release'); }")


class Browsers:
    """Headless Chromium with any number of browsers in it that know nothing of each other."""

    def __init__(self) -> None:
        path = shutil.which("chromium") or missing("chromium", "Chromium is not installed")
        try:
            from playwright.sync_api import sync_playwright
        except ImportError:
            missing("chromium", "playwright is not installed: pip install leadscrew[dev]")
        self._driver = sync_playwright().start()
        self._chromium = self._driver.chromium.launch(executable_path=path, headless=True, args=["--no-sandbox"])

    @contextmanager
    def context(self) -> Iterator[Any]:
        """A browser that knows nothing of the others and has opened nothing."""
        own = self._chromium.new_context()
        try:
            yield own
        finally:
            own.close()

    @contextmanager
    def view(self, served: Served, script: str = "", **context: Any) -> Iterator[View]:
        """A page in a browser of its own, after a script; the test fails where the page wrote an error."""
        own = self._chromium.new_context(**{"viewport": LAPTOP, "accept_downloads": True, **context})
        own.add_init_script(script)
        try:
            view = View(own.new_page(), served)
            try:
                yield view
            finally:
                view.leave()
            assert not view.wrong
        finally:
            own.close()

    def close(self) -> None:
        """Ends Chromium."""
        self._chromium.close()
        self._driver.stop()


@pytest.fixture(scope="module")
def browsers() -> Iterator[Browsers]:
    """Chromium, once for a file of tests."""
    found = Browsers()
    yield found
    found.close()


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """One panel for a file of tests."""
    panel = Served(tmp_path_factory.mktemp("panel"))
    yield panel
    panel.end()
