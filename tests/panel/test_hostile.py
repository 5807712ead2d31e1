"""Whatever a page sends: refused, noted, and the machine runs on with the same bits as if nobody had said anything."""

from __future__ import annotations

import json
import select
import socket
import time

import httpx
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from leadscrew.operate import session_file
from leadscrew.panel.messages import ALL
from tests.panel.served import Served

pytestmark = pytest.mark.slow
TOKEN = "a-token-that-nobody-guesses-42"


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hostile")
    (folder / "token").write_text(TOKEN)
    panel = Served(
        folder / "files", "vud_lathe", "-c", "ours.pd", "-s", "s_curve_m50", "--token-file", str(folder / "token")
    )
    assert panel.token == TOKEN
    yield panel
    assert panel.end() == 0
    words = panel.process.stderr.read()
    assert "Traceback" not in words and "Exception" not in words and TOKEN not in words, words
    assert TOKEN not in (folder / "files" / "audit.jsonl").read_text()


@pytest.fixture(scope="module")
def owner(served):
    """The page in control, with the machine running."""
    page = served.page(secret="the-owner-of-the-machine")
    if not page.machine:
        page.wait(lambda m: m.get("kind") == "machine")
    page.did("take")
    page.did("start")
    yield page
    page.close()


@pytest.fixture
def undisturbed(served, owner, tmp_path):
    """Afterwards the machine has run on, nothing of it has changed, and its bits are those of its record."""
    owner.listen(0.05)
    before, values = owner.did("ping", t=0.0), dict(owner.state.get("changed", {}))
    run, count = owner.machine["run"], len(refused(served))
    period = owner.until(lambda s: True)["period"]
    yield before
    state = owner.until(lambda s: s["period"] > period)
    assert state["running"] == "running" and state["changed"] == values and owner.machine["run"] == run
    path = tmp_path / "session.toml"
    path.write_text(served.get("api/session.toml").text)
    session = session_file.read(path)
    rerun = session.run(record=())
    assert rerun.identical and session.events == () and session.periods > period
    assert len(refused(served)) > count, "what was refused is noted"


def refused(served):
    lines = (served.folder / "audit.jsonl").read_text().splitlines()
    return [entry for entry in map(json.loads, lines) if not entry["ok"]]


def knocks(served, **more):
    """A connection that has not said hello, of somebody with the token."""
    given = {
        "subprotocols": ["leadscrew.1"],
        "origin": f"http://{served.address}",
        "max_size": None,
        "close_timeout": 1.0,
        "additional_headers": served.bearer,
    }
    return connect(f"ws://{served.address}/ws", **{**given, **more})


RAW = [
    '{"id":1,"do":"set","changes":{"controller.kp":NaN}}', '{"id":1,"do":"set","changes":{"controller.kp":1e400}}',
    '{"id":1,"do":"set","changes":{"controller.kp":-Infinity}}',
    '{"id":1,"do":"set","changes":{"controller.kp":"0.1"}}',
    '{"id":1,"do":"set","changes":{"controller.kp":[0.1]}}', '{"id":1,"do":"set","changes":{"controller.kp":true}}',
    '{"id":1,"do":"set","changes":{"controller.kq":1}}', '{"id":1,"do":"set","changes":{"__class__":1}}',
    '{"id":1,"do":"set","changes":{"controller.kp":1e-400,"controller.t_d":-1e300}}',
    '{"id":1,"do":"set","changes":{}}',
    '{"id":1,"do":"set","changes":{"seed":3}}', '{"id":1,"do":"set","changes":{"scenario.target_mm":-9e99}}',
    '{"id":1,"do":"set","changes":{"plant.full_duty_speed_mm_s":-1}}', '{"id":1,"do":"speed","value":-1}',
    '{"id":1,"do":"speed","value":1e308}', '{"id":1,"do":"speed","value":0}', '{"id":1,"do":"strat"}', "{", "[]", '""',
    '{"id":1,"do":"machine","study":"../../etc/passwd"}', '{"id":1,"do":"machine","study":"/tmp/x.py:STUDY"}',
    '{"id":1,"do":"machine","study":"vud_lathe","controller":"/tmp/x.py:c"}',
    '{"id":1,"do":"switch","controller":"/tmp/x.py:evil"}', '{"id":1,"do":"switch","controller":"../x.fis"}',
    '{"id":1,"do":"machine","study":"vud_lathe","changes":{"controller.kp":1e400}}', "[" * 60_000,
    '{"id":1,"do":"disturb","name":"no_such"}', '{"id":1,"do":"disturb","name":"../x"}',
    '{"id":1,"do":"arm","signal":"no_such","level":0}',
    '{"id":1,"do":"arm","signal":"error","level":0,"length_s":1e300}',
    '{"id":1,"do":"capture_load","name":"../../etc/passwd"}', '{"id":1,"do":"capture_load","name":"none.csv"}',
    '{"id":1,"do":"preset_load","name":"..%2f..%2fetc"}', '{"id":1,"do":"preset_save","name":"a/b"}',
    '{"id":1,"do":"preset_delete","name":"../audit"}', '{"id":1,"do":"session_save","name":"../../x"}',
    '{"id":1,"do":"capture_save","name":"x","format":"exe"}', '{"id":1,"do":"capture_save","name":"x","which":99}',
    '{"id":1,"do":"hello","name":"again"}', '{"id":-1,"do":"stop"}', '{"id":"1","do":"stop"}', '{"do":"stop"}',
    '{"id":1,"do":"stop","do":"stop"}', '{"id":1,"do":"stop","force":true}', '{"id":1e400,"do":"stop"}',
]  # fmt: skip


@pytest.mark.parametrize("writes", [True, False], ids=["in control", "watching"])
def test_what_makes_no_sense_is_refused(served, owner, undisturbed, writes):
    page = owner if writes else served.page(name="Eve", secret="secret-of-eve-123456")
    folder = {p.name for p in served.folder.rglob("*")}
    for text in RAW:
        page.socket.send(text)
        reply = page.wait(lambda m: "re" in m, 10)
        assert reply["ok"] is False, (text[:80], reply)
        assert 10 < len(reply["error"]) < 400 and "Traceback" not in reply["error"], (text[:80], reply)
        page.listen(0.02)
    assert {p.name for p in served.folder.rglob("*")} - folder <= {"audit.jsonl", "captures", "presets", "sessions"}
    if not writes:
        page.close()


values = (
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=30) | st.lists(st.floats(), max_size=3)
)
names = st.sampled_from(
    ["controller.kp", "plant.full_duty_speed_mm_s", "scenario.target_mm", "seed", "x" * 300, "../x", ""]
)
messages = st.fixed_dictionaries(
    {"id": st.just(5), "do": st.sampled_from(sorted(ALL)) | st.text(max_size=12)},
    optional={"changes": st.dictionaries(names, values, max_size=3), "name": values | names, "study": values | names,
              "controller": values, "scenario": values, "value": values,
              "fields": st.dictionaries(names, values, max_size=2),
              "signal": values, "level": values, "views": values, "format": values, "last": values, "mode": values},
)  # fmt: skip


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.one_of(messages.map(json.dumps), st.text(max_size=300), st.binary(max_size=300)))
def fuzz(page, data):
    """One message of any kind from a page without control: an answer comes, and the line stays."""
    page.socket.send(data)
    page.number += 1
    page.socket.send(json.dumps({"id": 2**40 + page.number, "do": "ping", "t": 1.0}))
    page.wait(lambda m: m.get("re") == 2**40 + page.number, 10)
    time.sleep(0.03)


def test_anything_at_all_from_a_page_that_watches_leaves_the_machine_alone(served, owner, undisturbed):
    page = served.page(name="Eve", secret="secret-of-eve-123456")
    fuzz(page)
    page.close()


def test_a_second_page_cannot_take_control_nor_write(served, owner, undisturbed):
    eve = served.page(name="Eve", secret="secret-of-eve-123456")
    assert "Ann has control" in eve.ask("take")["error"]
    for do, args in (("set", {"changes": {"controller.kp": 0.3}}), ("stop", {}), ("hold", {}), ("release", {}),
                     ("speed", {"value": 2.0}), ("machine", {"study": "grey_turning"}), ("undo", {}),
                     ("switch", {"controller": "ours.pd"}),
                     ("preset_save", {"name": "x"}), ("disturb", {"name": "x"}), ("force", {})):  # fmt: skip
        assert "Ann has control" in eve.ask(do, **args)["error"]
    eve.close()


@pytest.mark.parametrize("token", [None, "", TOKEN[:-1], TOKEN + "x", TOKEN.upper(), TOKEN])
def test_a_wrong_token_opens_nothing(served, owner, undisturbed, token):
    who = {} if token is None else {"authorization": f"Bearer x{token}", "cookie": f"leadscrew_{served.port}={token}"}
    with pytest.raises(InvalidStatus) as refusal, knocks(served, additional_headers=who):
        pass
    assert refusal.value.response.status_code == 401 and b"open the link" in refusal.value.response.body
    for path in ("", "static/app.js", "api/session.py", "api/session.toml", "api/report.html", "api/captures/x.csv"):
        link = {"token": token or ""} if path or token != TOKEN else {}
        reply = httpx.get(f"http://{served.address}/{path}", params=link, headers=who)
        assert reply.status_code == 401 and "open the link" in reply.text


def test_other_origins_hosts_and_protocols_do_not_get_a_line(served, owner, undisturbed):
    for more in ({"origin": "http://evil.example"}, {"origin": None}, {"origin": f"https://{served.address}"}):
        with pytest.raises(InvalidStatus) as status, knocks(served, **more):
            pass
        assert status.value.response.status_code == 403
    with pytest.raises(InvalidStatus), knocks(served, subprotocols=["something.else"]):
        pass
    with socket.create_connection(("127.0.0.1", served.port)) as plain:
        plain.sendall(b"GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n")
        assert b" 421 " in plain.recv(1000).splitlines()[0]


def test_a_message_too_large_ends_only_its_own_line(served, owner, undisturbed):
    eve = served.page(name="Eve", secret="secret-of-eve-123456")
    with pytest.raises(ConnectionClosed):
        eve.socket.send(json.dumps({"id": 1, "do": "ping", "t": 1.0, "x": "x" * 70_000}))
        eve.listen(5)
    assert "more than 64 KB" in refused(served)[-1]["error"]
    eve.drop()


def test_a_flood_is_cut_off_and_the_owner_keeps_control(served, owner, undisturbed):
    eve = served.page(name="Eve", secret="secret-of-eve-123456")
    before = (served.folder / "audit.jsonl").stat().st_size
    with pytest.raises((ConnectionClosed, OSError)):
        for _ in range(50):
            for i in range(1000):
                eve.socket.send(json.dumps({"id": i, "do": "set", "changes": {"controller.kp": 0.5}}))
            eve.listen(0.001)
    eve.drop()
    assert (served.folder / "audit.jsonl").stat().st_size - before < 300_000
    assert owner.did("ping", t=3.0) == {"t": 3.0}


LATIN = b"\xff\xfe\xe9"
OWN = b"Host: %s\r\nOrigin: http://%s\r\n%s"


@pytest.mark.parametrize(
    "frame", [LATIN, b'{"id":1,"do":"\xff"}', b"\xed\xa0\x80"], ids=["bytes", "in a text", "surrogate"]
)
@pytest.mark.parametrize("greets", [True, False])
def test_a_text_that_is_no_utf8_ends_its_own_line_and_is_noted(served, owner, undisturbed, frame, greets):
    with knocks(served) as line:
        if greets:
            line.send(json.dumps({"id": 1, "do": "hello", "name": "Eve"}))
        line.send(frame, text=True)
        with pytest.raises(ConnectionClosed) as closed:
            while True:
                line.recv(timeout=10)
    assert closed.value.rcvd.code == 1007
    owner.wait(lambda m: m.get("kind") == "audit" and "not UTF-8" in m["entry"]["error"], 10) if greets else None
    while "not UTF-8" not in refused(served)[-1]["error"]:
        time.sleep(0.05)


@pytest.mark.parametrize(
    "start",
    [b"GET /" + LATIN + b" HTTP/1.1\r\n", b"GET /%ff%fe HTTP/1.1\r\n", b"GET /static/%ff%00 HTTP/1.1\r\n",
     b"GET /static/" + b"a" * 5000 + b" HTTP/1.1\r\n", b"GET /?token=" + LATIN + b" HTTP/1.1\r\n",
     b"GET /?token=%ff HTTP/1.1\r\n", b"GET /ws?%ff HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n",
     b"GET /ws HTTP/1.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
     b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: " + LATIN + b"\r\n",
     b"GET /ws HTTP/1.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Key: " + LATIN + b"\r\n",
     b"GET / HTTP/1.1\r\nUpgrade: " + LATIN + b"\r\nConnection: Upgrade\r\n",
     b"GET / HTTP/1.1\r\nCookie: " + LATIN + b"\r\n", b"GET / HTTP/1.1\r\nX-" + LATIN + b": 1\r\n",
     b"GET /static/app.js HTTP/1.1\r\nIf-None-Match: " + LATIN + b"\r\nIf-Modified-Since: " + LATIN + b"\r\n",
     b"GET /static/app.js HTTP/1.1\r\nRange: bytes=" + LATIN + b"\r\n", LATIN + b" / HTTP/1.1\r\n",
     b"POST /api/captures/%ff.csv HTTP/1.1\r\nContent-Length: 1\r\n",
     b"POST /api/captures/" + LATIN + b".csv HTTP/1.1\r\nContent-Length: 1\r\n",
     b"POST /api/captures/a.csv HTTP/1.1\r\nContent-Length: " + LATIN + b"\r\n",
     b"POST /api/captures/a.csv HTTP/1.1\r\nLeadscrew-Secret: " + LATIN + b"\r\nContent-Length: 1\r\n"],
)  # fmt: skip
def test_a_request_that_is_no_utf8_gets_an_answer(served, owner, start):
    for who in (b"", b"Authorization: Bearer " + TOKEN.encode() + b"\r\n"):
        address = served.address.encode()
        with socket.create_connection(("127.0.0.1", served.port), timeout=20) as line:
            line.sendall(start + OWN % (address, address, who) + b"\r\nx")
            assert line.recv(4096).startswith(b"HTTP/1.1 ")
    assert owner.did("ping", t=5.0) == {"t": 5.0}


def test_silent_connections_keep_nobody_out(served, owner, undisturbed):
    lines = [socket.create_connection(("127.0.0.1", served.port), timeout=60) for _ in range(300)]
    eve = served.page(name="Eve", secret="secret-of-eve-123456")
    assert eve.did("ping", t=1.0) == {"t": 1.0} and served.get("").status_code == 200
    assert "Ann has control" in eve.ask("stop")["error"]
    eve.close()
    ends = time.monotonic() + 60
    while lines and time.monotonic() < ends:
        owner.listen(0.2)
        for line in select.select(lines, [], [], 0)[0]:
            assert line.recv(1) == b""
            lines.remove(line)
    assert not lines, "the server ends them"


def test_pieces_of_http_and_half_open_lines_hold_nothing_up(served, owner, undisturbed):
    lines = [socket.create_connection(("127.0.0.1", served.port)) for _ in range(30)]
    for i, line in enumerate(lines):
        line.sendall(
            [b"GET /", b"\x00" * 500, b"POST /api/captures/a.csv HTTP/1.1\r\nHost: x\r\n", b"\x16\x03\x01"][i % 4]
        )
    silent = [knocks(served) for _ in range(5)]
    assert owner.did("ping", t=4.0) == {"t": 4.0}
    for line in lines:
        line.close()
    del silent
    with knocks(served) as line:
        line.send('{"id":1,"do":"start"}')
        assert json.loads(line.recv(timeout=5))["ok"] is False
