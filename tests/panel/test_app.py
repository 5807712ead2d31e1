"""The web application at its door, before a machine stands behind it."""

import json

import pytest
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from leadscrew.panel.app import application
from leadscrew.panel.audit import Audit
from leadscrew.panel.gate import Gate
from leadscrew.panel.hub import Hub
from leadscrew.panel.link import NoAnswer

ADDRESS = "127.0.0.1:8420"
TOKEN = "the-right-token-0123456789"
HEADERS = {"host": ADDRESS, "origin": f"http://{ADDRESS}"}


class NoMachine:
    """In place of the machine's process: notes what reaches it, and gives nothing away."""

    alive = True

    def __init__(self):
        self.asked = []

    def listen(self, heard, lost):
        self.heard, self.lost = heard, lost

    def begin(self):
        pass

    def remember(self, machine):
        pass

    async def ask(self, do, args):
        self.asked.append((do, args))
        if do == "session":
            return {"text": "text of the session"}
        if do == "capture_receive":
            if "bad" in args["name"]:
                raise NoAnswer(f"{args['name']} holds no rows")
            return {"name": args["name"], "rows": 3}
        return {"period": 5, "t": 0.5, "old": {"controller.kp": 1.0}, "new": {"controller.kp": 2.0}}

    def tell(self, do, args, ticket=0):
        self.asked.append((do, args))

    def close(self):
        pass


def panel(tmp_path, token=""):
    link = NoMachine()
    gate = Gate("127.0.0.1", 8420, token)
    audit = Audit(tmp_path)
    hub = Hub(link, audit, gate, 30.0)
    client = TestClient(application(hub, gate, tmp_path), base_url=f"http://{ADDRESS}")
    return client, link, audit


def line(client, name="Ann", origin=f"http://{ADDRESS}", host=ADDRESS, **hello):
    headers = {"host": host, **({"origin": origin} if origin else {})}
    return client.websocket_connect("/ws", subprotocols=["leadscrew.1"], headers=headers)


def said(socket, do, number=1, **args):
    socket.send_text(json.dumps({"id": number, "do": do, **args}))
    while True:
        message = json.loads(socket.receive_text())
        if message.get("re") == number:
            return message


def errors(audit):
    return [e["error"] for e in audit.last(100) if not e["ok"]]


def test_the_page_comes_with_headers_that_keep_others_out(tmp_path):
    client, _, _ = panel(tmp_path)
    with client:
        reply = client.get("/")
        assert reply.status_code == 200 and reply.headers["content-type"].startswith("text/html")
        for found in (reply, client.get("/static/app.js"), client.get("/static/none.js"), client.get("/nothing")):
            assert "default-src 'self'" in found.headers["content-security-policy"]
            assert "frame-ancestors 'none'" in found.headers["content-security-policy"]
            assert found.headers["x-content-type-options"] == "nosniff"
            assert "server" not in found.headers


@pytest.mark.parametrize(
    "path",
    ["/static/../app.py", "/static/%2e%2e/app.py", "/static//etc/passwd", "/static/..%2fapp.py",
     "/api/captures/..%2f..%2fetc%2fpasswd", "/api/captures/%2e%2e", "/api/captures/a.csv%00"],
)  # fmt: skip
def test_no_path_leads_out_of_the_folders(tmp_path, path):
    client, _, _ = panel(tmp_path)
    with client:
        reply = client.get(path)
        assert reply.status_code == 404 and "import" not in reply.text and "root:" not in reply.text


def test_a_foreign_host_sees_nothing_and_is_noted(tmp_path):
    client, _, audit = panel(tmp_path)
    with client:
        assert client.get("/", headers={"host": "evil.example:8420"}).status_code == 421
        with pytest.raises(Exception), line(client, host="evil.example:8420"):  # noqa: B017
            pass
    assert len(errors(audit)) == 2 and "not known under the address" in errors(audit)[0]


@pytest.mark.parametrize("origin", ["http://evil.example", "", "null", f"https://{ADDRESS}"])
def test_a_foreign_page_may_neither_connect_nor_post(tmp_path, origin):
    client, link, audit = panel(tmp_path)
    with client:
        with pytest.raises(Exception), line(client, origin=origin):  # noqa: B017
            pass
        headers = {"origin": origin} if origin else {}
        assert client.post("/api/captures/a.csv", content=b"x", headers=headers).status_code == 403
    assert len(errors(audit)) == 2 and link.asked == []


def test_a_wrong_token_gets_nothing_at_all_and_stands_in_no_log(tmp_path):
    client, link, audit = panel(tmp_path, TOKEN)
    with client:
        for wrong in ("wrong-token-012345678", None):
            with line(client) as socket:
                reply = said(socket, "hello", name="Eve", token=wrong)
                assert reply["ok"] is False and "token" in reply["error"]
                with pytest.raises(WebSocketDisconnect):
                    socket.receive_text()
        for path in ("/api/session.py", "/api/session.py?token=wrong-token-012345678", "/api/captures/a.csv"):
            assert client.get(path).status_code == 401
        assert client.get("/").status_code == 200
        assert link.asked == []
        assert client.get(f"/api/session.py?token={TOKEN}").status_code == 401, "no token in an address"
        bearer = {"authorization": f"Bearer {TOKEN}"}
        assert client.get("/api/session.py", headers=bearer).text == "text of the session"
        assert client.get("/api/session.toml", headers=bearer).status_code == 200
        with line(client) as socket:
            assert said(socket, "hello", name="Ann", token=TOKEN)["ok"]
    log = (tmp_path / "audit.jsonl").read_text()
    assert "wrong-token" not in log and TOKEN not in log and len(errors(audit)) == 6


@pytest.mark.parametrize("first", ['{"id":1,"do":"start"}', "x", '{"id":1,"do":"hello"}', '{"id":1,"do":"take"}'])
def test_nothing_goes_before_the_hello(tmp_path, first):
    client, link, audit = panel(tmp_path)
    with client, line(client) as socket:
        socket.send_text(first)
        assert json.loads(socket.receive_text())["ok"] is False
        with pytest.raises(WebSocketDisconnect):
            socket.receive_text()
    assert link.asked == [] and len(errors(audit)) == 1


def test_only_the_page_in_control_writes_and_every_change_is_noted_with_old_and_new(tmp_path):
    client, link, audit = panel(tmp_path)
    with client, line(client) as ann, line(client) as bob:
        assert said(ann, "hello", name="Ann", secret="a" * 16)["result"] == {"you": 1, "writer": False}
        said(bob, "hello", name="Bob", secret="b" * 16)
        assert "take control first" in said(ann, "start", 2)["error"]
        assert said(ann, "take", 3)["ok"]
        assert "Ann has control" in said(bob, "take", 2)["error"]
        assert "Ann has control" in said(bob, "set", 3, changes={"controller.kp": 1.0})["error"]
        assert [a for a in link.asked if a[0] != "views"] == []
        assert said(ann, "set", 4, changes={"controller.kp": 2.0})["ok"]
        assert said(bob, "audit", 4, last=10)["result"]["entries"][-1]["new"] == 2.0
        assert said(ann, "release", 5)["ok"] and said(bob, "take", 5)["ok"]
    changed = [e for e in audit.last(50) if e["what"] == "set" and e["ok"]]
    assert [(e["who"], e["key"], e["old"], e["new"], e["t"]) for e in changed] == [
        ("Ann", "controller.kp", 1.0, 2.0, 0.5)
    ]
    assert [e["who"] for e in audit.last(50) if not e["ok"]] == ["Ann", "Bob", "Bob"]


def test_a_page_that_comes_back_with_its_key_has_control_again(tmp_path):
    client, _, _ = panel(tmp_path)
    with client:
        with line(client) as ann:
            said(ann, "hello", name="Ann", secret="a" * 16)
            said(ann, "take", 2)
        with line(client) as eve:
            assert said(eve, "hello", name="Ann", secret="e" * 16)["result"]["writer"] is False
            assert "Ann has control" in said(eve, "take", 2)["error"]
        with line(client) as again:
            assert said(again, "hello", name="Ann", secret="a" * 16)["result"]["writer"] is True


def test_binary_and_broken_messages_are_answered_and_the_line_stays(tmp_path):
    client, link, audit = panel(tmp_path)
    with client, line(client) as socket:
        said(socket, "hello", name="Ann")
        socket.send_bytes(b"\x00" * 100)
        socket.send_text('{"id":9,"do":"set","changes":{"controller.kp":NaN}}')
        assert said(socket, "ping", 3, t=2.5)["result"] == {"t": 2.5}
    assert [a for a in link.asked if a[0] != "views"] == []
    assert "binary messages are not taken" in errors(audit) and any("NaN" in e for e in errors(audit))


def test_a_capture_is_sent_kept_where_it_can_be_read_and_refused_where_not(tmp_path):
    client, link, _ = panel(tmp_path)
    with client:
        ours = {"origin": f"http://{ADDRESS}"}
        assert client.post("/api/captures/a.csv", content=b"1,2", headers=ours).json() == {"name": "a.csv", "rows": 3}
        assert client.post("/api/captures/bad.csv", content=b"1,2", headers=ours).text == "bad.csv holds no rows"
        asked = len(link.asked)
        for name in ("a.sh", "..csv", "%2e%2e%2fa.csv", "a"):
            assert client.post(f"/api/captures/{name}", content=b"x", headers=ours).status_code in (400, 404)
        large = {**ours, "content-length": str(50_000_001)}
        assert client.post("/api/captures/b.csv", content=b"x", headers=large).status_code == 413
        assert len(link.asked) == asked
        (tmp_path / "captures").mkdir()
        (tmp_path / "captures" / "k.csv").write_text("t,x\n")
        reply = client.get("/api/captures/k.csv")
        assert reply.text == "t,x\n" and "attachment" in reply.headers["content-disposition"]
    assert [p.name for p in tmp_path.iterdir() if p.name.startswith(".upload")] == []


def test_a_slow_page_loses_the_oldest_frames_and_no_answer():
    from leadscrew.panel.client import MOST_FRAMES, Client

    client = Client(1, "here")
    client.put("first")
    for i in range(3 * MOST_FRAMES):
        client.put_frame(bytes([1, 1, i % 256]))
        client.put_latest("state", f"state {i}")
    client.put("last")
    got = []
    while (message := client.take()) is not None:
        got.append(message)
    assert got[0] == "first" and got[-1] == "last"
    assert [m for m in got if isinstance(m, str)] == ["first", f"state {3 * MOST_FRAMES - 1}", "last"]
    frames = [m for m in got if isinstance(m, bytes)]
    assert len(frames) == MOST_FRAMES and frames[-1][2] == (3 * MOST_FRAMES - 1) % 256
    assert client.dropped() == 2 * MOST_FRAMES and client.dropped() == 0


@pytest.mark.parametrize("site, status", [("cross-site", 403), ("same-site", 403), ("same-origin", 200), ("none", 200)])
def test_a_download_is_not_started_by_a_page_of_another_site(tmp_path, site, status):
    client, link, _ = panel(tmp_path)
    assert client.get("/api/session.toml", headers={"sec-fetch-site": site}).status_code == status
    assert bool(link.asked) is (status == 200)


def test_a_name_that_reads_as_another_is_refused(tmp_path):
    client, _, audit = panel(tmp_path)
    for name in ("\u202eevil", "a\nb", "a\x00", "  ", "\u200bAnn"):
        with client, client.websocket_connect("/ws", subprotocols=["leadscrew.1"], headers=HEADERS) as socket:
            socket.send_json({"id": 1, "do": "hello", "name": name})
            assert socket.receive_json()["ok"] is False
    assert len(errors(audit)) == 5
