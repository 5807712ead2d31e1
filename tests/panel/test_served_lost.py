"""Pages, machines and servers that are lost, killed or silent: what goes on, and what is kept."""

from __future__ import annotations

import os
import signal
import socket
import time

import numpy as np
import psutil
import pytest

from leadscrew.operate import session_file
from tests.panel.served import Served

pytestmark = pytest.mark.slow


def test_a_lost_connection_stops_nothing_and_the_page_comes_back_to_all_of_it(served, page, tmp_path):
    page.did("start")
    page.listen(0.5)
    last = page.column("feedback")[0][-1]
    page.drop()
    time.sleep(0.7)
    again = served.page(secret="secret-of-this-test", since=float(last))
    assert again.hello["result"]["writer"] is True
    again.listen(0.5)
    periods, _ = again.column("feedback")
    assert periods[0] <= last + 1
    np.testing.assert_array_equal(np.diff(periods), 1.0)
    assert again.state["running"] == "running" and again.state["writer"]["id"] == again.hello["result"]["you"]
    assert again.ask("set", changes={"controller.kp": 0.02})["ok"]
    again.close()


def test_without_its_page_the_machine_goes_back_to_safe_values_and_control_is_free(served, page):
    page.did("start")
    before = next(p["value"] for p in page.machine["parameters"] if p["key"] == "controller.kp")
    page.did("set", changes={"controller.kp": 0.02})
    watcher = served.page(name="Bob", secret="secret-of-somebody-else")
    assert watcher.ask("take")["ok"] is False
    page.drop()
    watcher.until(lambda s: s["changed"].get("controller.kp") == 0.02 and s["writer"]["id"] == 0, 5)
    entry = watcher.wait(lambda m: m.get("kind") == "audit" and m["entry"]["what"] == "safe values", 8)["entry"]
    assert (entry["key"], entry["old"], entry["new"]) == ("controller.kp", 0.02, before)
    state = watcher.until(lambda s: s["writer"] is None, 5)
    assert state["running"] == "running" and "controller.kp" not in state["changed"]
    assert watcher.ask("take")["ok"]
    watcher.did("release")
    watcher.close()


def test_a_page_that_reads_nothing_slows_nobody(served, page):
    lazy = served.page(name="Bob")
    lazy.socket.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    page.did("start")
    n = len(page.frames)
    for _ in range(120):
        page.listen(0.5)
        if len(page.frames) > n + 100:  # more than the other's buffers take
            break
    assert len(page.frames) > n + 100
    lazy.drop()
    assert page.did("ping", t=1.0) == {"t": 1.0}


def test_a_killed_machine_comes_back_at_rest_and_the_panel_lives(served, page):
    page.did("start")
    page.listen(0.2)
    run = page.machine["run"]
    os.kill(served.worker(), signal.SIGKILL)
    notice = page.wait(lambda m: m.get("kind") == "notice" and m["level"] == "error", 10)
    assert "signal 9" in notice["text"] and "started again" in notice["text"]
    assert "cannot be replayed" in notice["text"] and "audit" in notice["text"]
    page.wait(lambda m: m.get("kind") == "machine", 20)
    state = page.until(lambda s: s["running"] == "stopped")
    assert state["t"] == 0 and page.machine["run"] > run and page.machine["controller"] == "ours.pd"
    page.did("start")
    page.until(lambda s: s["t"] > 0.1)


def test_a_killed_server_takes_the_machine_with_it(tmp_path):
    panel = Served(tmp_path, "vud_lathe")
    page = panel.page()
    if not page.machine:
        page.wait(lambda m: m.get("kind") == "machine")
    worker = panel.worker()
    panel.process.kill()
    panel.process.wait(5)
    _, alive = psutil.wait_procs([psutil.Process(worker)] if psutil.pid_exists(worker) else [], timeout=5)
    assert not alive


def test_control_c_while_the_machine_is_built_ends_both(tmp_path):
    panel = Served(tmp_path, "sofnn_tangent")
    children = psutil.Process(panel.process.pid).children()
    assert panel.end() in (0, 130)
    _, alive = psutil.wait_procs(children, timeout=5)
    assert not alive
    assert "Traceback" not in panel.process.stderr.read()


def test_a_page_whose_network_is_gone_without_a_word_is_noticed(served, page):
    page.did("release")
    with socket.create_connection(("127.0.0.1", served.port)) as silent:
        silent.sendall(
            f"GET /ws HTTP/1.1\r\nHost: {served.address}\r\nOrigin: http://{served.address}\r\nUpgrade: websocket\r\n"
            f"Authorization: Bearer {served.token}\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: leadscrew.1\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
        )
        assert silent.recv(4096).startswith(b"HTTP/1.1 101")
        for text in (b'{"id":1,"do":"hello","name":"Cleo","secret":"0123456789abcdef"}', b'{"id":2,"do":"take"}'):
            silent.sendall(bytes([0x81, 0x80 | len(text), 0, 0, 0, 0]) + text)
        page.until(lambda s: s["writer"] is not None and s["writer"]["name"] == "Cleo", 5)
        page.until(lambda s: s["writer"] is not None and s["writer"]["id"] == 0, 25)
        page.until(lambda s: s["writer"] is None, 10)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_the_session_of_the_run_is_kept_however_the_server_ends(tmp_path, number):
    panel = Served(tmp_path, "npid_xytable")
    page = panel.page()
    page.did("take")
    page.wait(lambda m: m.get("kind") == "machine") if not page.machine else None
    page.did("start")
    page.until(lambda s: s["t"] > 0.2)
    page.did("set", changes={"controller.kp": 2.0})
    page.until(lambda s: s["t"] > 0.4)
    worker = psutil.Process(panel.worker())
    panel.process.send_signal(number)
    panel.process.wait(8)
    worker.wait(8)
    (kept,) = (tmp_path / "sessions").glob("run-*.toml")
    session = session_file.read(kept)
    assert session.periods * 0.001 > 0.2 and session.events[-1].changes["controller.kp"] == 2.0
    assert session.run(record=()).identical
    said = panel.process.stdout.read() + panel.process.stderr.read()
    assert (str(kept) in said) is (number != signal.SIGKILL) and "Traceback" not in said
    assert kept.parent.stat().st_mode & 0o077 == 0, "nobody else can read it"
