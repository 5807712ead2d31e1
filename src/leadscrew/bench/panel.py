"""Rows of the operator panel in Chromium: first paint, frames a second, change to visible, processor time, memory."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Any

from leadscrew.bench.measuring import row

STUDY = "vud_lathe"
"""A loop of 1 kHz."""
SIGNALS = 8
CHANGE_EVERY_S = 2.0
TAUS = (0.9, 0.85)
WARM_S, LONG_S, QUICK_S = 60.0, 600.0, 10.0
"""Memory is first read after WARM_S; the whole takes LONG_S."""


def lacking() -> str:
    """What is missing here to look at a page, as words; empty if nothing is."""
    try:
        import playwright  # noqa: F401
    except ImportError:
        return "Playwright is not installed: pip install leadscrew[verify]"
    return "" if browser() else "Chromium is not installed"


def browser() -> str | None:
    """Path of Chromium."""
    return shutil.which("chromium") or shutil.which("chromium-browser")


class Server:
    """``leadscrew panel`` in a process of its own."""

    def __init__(self, folder: str) -> None:
        command = [sys.executable, "-m", "leadscrew", "panel", STUDY, "--port", "0", "--no-open", "--folder", folder]
        self.began = time.time()
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert self.process.stdout is not None
        said = ""
        for line in self.process.stdout:
            said += line
            found = re.search(r"http://\S+", line)
            if found:
                self.address = found[0]
                return
        raise RuntimeError(f"leadscrew panel printed no address: {said}")

    def processes(self) -> list[int]:
        """The server and what it started."""
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        return [self.process.pid, *map(int, children)]

    def seconds(self) -> float:
        """Processor seconds of all of them so far."""
        ticks = 0
        for pid in self.processes():
            fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
            ticks += int(fields[11]) + int(fields[12])
        return ticks / os.sysconf("SC_CLK_TCK")

    def megabytes(self) -> float:
        """Resident memory of all of them."""
        lines = (line for pid in self.processes() for line in Path(f"/proc/{pid}/status").read_text().splitlines())
        return sum(float(line.split()[1]) for line in lines if line.startswith("VmRSS")) / 1024.0

    def close(self) -> None:
        """Ends it as Ctrl-C does."""
        import signal

        self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(10.0)
        except subprocess.TimeoutExpired:
            self.process.kill()


def watched(seconds: float) -> dict[str, Any]:
    """What a page shows of a running machine for some seconds, a parameter changed every two."""
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory(prefix="leadscrew-bench-") as folder, sync_playwright() as player:
        chrome = player.chromium.launch(executable_path=browser(), args=["--no-sandbox"])
        server = Server(folder)
        try:
            page = chrome.new_page(viewport={"width": 1280, "height": 720})
            page.goto(server.address)
            _until(page, "performance.getEntriesByName('first-paint').length > 0")
            paint = page.evaluate("performance.timeOrigin + performance.getEntriesByName('first-paint')[0].startTime")
            _until(page, "window.panel?.state?.running == 'stopped'")
            page.evaluate("panel.send('take', {}).then(() => panel.send('start', {}))")
            drawn = page.evaluate("panel.machine.plots.reduce((n, p) => n + p.traces.length, 0)")
            found = _changing(page, server, seconds)
            return {**found, "paint": paint / 1000.0 - server.began, "drawn": drawn}
        finally:
            server.close()
            chrome.close()


def _until(page: Any, said: str, seconds: float = 60.0) -> None:
    """Waits; the page's own policy lets no string be evaluated inside it, so it is asked from outside."""
    ends = time.perf_counter() + seconds
    while not page.evaluate(said):
        if time.perf_counter() > ends:
            raise TimeoutError(f"the page did not get there in {seconds:g} s: {said}")
        page.wait_for_timeout(5)


def _changing(page: Any, server: Server, seconds: float) -> dict[str, Any]:
    page.wait_for_timeout(2000)
    frames, heaps, memory = [], [], []
    used, began, changes = server.seconds(), time.perf_counter(), 0
    while (at := time.perf_counter() - began) < seconds:
        page.evaluate("tau => panel.send('set', {changes: {'controller.tau': tau}})", TAUS[changes % 2])
        changes += 1
        page.wait_for_timeout(1000 * max(0.0, changes * CHANGE_EVERY_S - (time.perf_counter() - began)))
        frames.append(page.evaluate("panel.measures.fps"))
        if at >= WARM_S or seconds < WARM_S:
            memory.append(server.megabytes())
            heaps.append(page.evaluate("performance.memory ? performance.memory.usedJSHeapSize / 2 ** 20 : 0"))
    share = (server.seconds() - used) / (time.perf_counter() - began)
    return {
        "seconds": time.perf_counter() - began, "fps": median(frames), "fps_least": min(frames),
        "latency": page.evaluate("Array.from(panel.measures.latency_ms)"), "cpu": 100.0 * share,
        "growth": memory[-1] - memory[0], "memory": memory[-1], "heap": (heaps[0], heaps[-1]),
        "t": page.evaluate("panel.state.t"), "behind": page.evaluate("panel.state.behind"),
    }  # fmt: skip


def rows(quick: bool) -> list[dict[str, Any]]:
    """The rows; one without a value where there is no Chromium or Playwright."""
    from leadscrew.bench.measuring import load

    missing = lacking()
    if missing:
        return [row("panel", "not measured", None, "", remark=missing)]
    before = load()
    f = watched(QUICK_S if quick else LONG_S)
    what = f"{STUDY} at 1 kHz in real time, {f['drawn']} signals drawn, {f['seconds']:.0f} s"
    late = ", behind real time" if f["behind"] else ""
    said = f"load {before:.2f} before" if before is not None else "load unknown"
    made = [
        row("panel", f"{what}: frames in the page, median", f["fps"], "1/s", at_least=30.0,
            remark=f"least {f['fps_least']:.0f}; software rendering; simulated {f['t']:.1f} s{late}; {said}"),
        row("panel", f"{what}: change to visible, median", median(f["latency"]), "ms", at_most=150.0,
            remark=f"{len(f['latency'])} changes, worst {max(f['latency']):.0f} ms"),
        row("panel", f"{what}: server and machine", f["cpu"], "% of a core", at_most=60.0, remark="both processes"),
        row("panel", "first paint after the command", f["paint"], "s", at_most=2.0,
            remark="the browser runs already"),
    ]  # fmt: skip
    if not quick:
        made.append(
            row("panel", f"memory of server and machine, {WARM_S / 60:.0f} to {LONG_S / 60:.0f} min", f["growth"], "MB",
                at_most=5.0, remark=f"grown; {f['memory']:.0f} MB at the end; the page's heap {f['heap'][0]:.0f} to "
                f"{f['heap'][1]:.0f} MB")
        )  # fmt: skip
    return made
