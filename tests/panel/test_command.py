"""``leadscrew panel`` at the command line: it says where it is, and what is wrong in one sentence."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from queue import Queue

import pytest

from leadscrew.cli.panel import _open
from leadscrew.panel.serve import Options, address, bound, token_for
from leadscrew.util.errors import DataError, ValueRefused

LEADSCREW = [sys.executable, "-m", "leadscrew", "panel", "--no-open"]


def test_a_port_that_is_taken_is_said_with_what_to_do():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(ValueRefused, match=rf"--port {port}: another program has it .*--port 0 for a free one"):
            bound("127.0.0.1", port)


def test_port_0_takes_a_free_one_and_answers_are_not_held_back():
    with bound("127.0.0.1", 0) as found:
        assert found.getsockname()[1] > 1023
        assert found.proto == socket.IPPROTO_TCP, "else asyncio leaves Nagle's delay of 40 ms on"


@pytest.mark.parametrize("host", ["203.0.113.7", "no-such-host.invalid", "x y"])
def test_an_address_of_another_computer_is_refused(host):
    with pytest.raises(ValueRefused, match="give an address of this computer"):
        bound(host, 0)


def test_every_panel_has_a_token_and_it_stands_in_the_link(tmp_path):
    assert len(token_for(None)) >= 30 and token_for(None) != token_for(None)
    (tmp_path / "t").write_text("0123456789abcdef\n")
    assert token_for(tmp_path / "t") == "0123456789abcdef"
    for text in ("short", "x" * 300, "two words of a token here", "zeile\nzeile zeile zeile", "ä" * 20):
        (tmp_path / "t").write_text(text)
        with pytest.raises(DataError, match="--token-file"):
            token_for(tmp_path / "t")
    with pytest.raises(DataError, match="cannot be read"):
        token_for(tmp_path / "none")
    assert address(Options("abc"), 8420) == "http://127.0.0.1:8420/?token=abc"
    assert address(Options("a&b#c", "::1"), 80) == "http://[::1]:80/?token=a%26b%23c"


def test_no_other_user_sees_the_token_when_the_browser_is_opened(tmp_path, monkeypatch):
    import webbrowser

    seen = Queue()
    monkeypatch.setattr(webbrowser, "open", lambda address: seen.put(address) or True)
    page = tmp_path / "open-1.html"
    _open("http://127.0.0.1:8420/?token=a%26b&x", page)
    assert seen.get(timeout=10) == page.as_uri(), "a command line, which everybody can list, holds no token"
    assert "url=http://127.0.0.1:8420/?token=a%26b&amp;x" in page.read_text()
    assert os.name != "posix" or page.stat().st_mode & 0o077 == 0


def test_the_server_loads_nothing_that_computes():
    code = (
        "import sys; import leadscrew.cli; from leadscrew.panel import app, audit, hub, link, serve; import uvicorn; "
        "print([m for m in ('numpy', 'llvmlite', 'scipy', 'matplotlib', 'pyarrow', 'control') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.slow
@pytest.mark.parametrize(
    "words, why",
    [
        (["vud_lahte"], "did you mean vud_lathe"),
        (["vud_lathe", "-c", "no_such"], "has no controller 'no_such'"),
        (["vud_lathe", "-s", "no_such"], "has no scenario 'no_such'"),
        (["none.toml"], "none.toml"),
        (["none.py:STUDY"], "none.py"),
        (["--hal", "none.toml"], "there is no such file"),
        (["vud_lathe", "--hal", "none.toml"], "give no STUDY"),
        (["--host", "203.0.113.7"], "give an address of this computer"),
        (["--token-file", "none"], "cannot be read"),
    ],
)
def test_what_cannot_be_is_one_sentence_and_exit_code_2(tmp_path, words, why):
    words = [*words, "--port", "0", "--folder", str(tmp_path / "files")]
    done = subprocess.run([*LEADSCREW, *words], capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert done.returncode == 2, done.stderr
    assert why in done.stderr and len(done.stderr.strip().splitlines()) == 1, done.stderr


@pytest.mark.slow
def test_a_folder_that_cannot_be_written_is_said(tmp_path):
    (tmp_path / "file").write_text("")
    words = ["--port", "0", "--folder", str(tmp_path / "file" / "x")]
    done = subprocess.run([*LEADSCREW, *words], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and "give another --folder" in done.stderr
