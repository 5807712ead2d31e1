"""The web application at its guard, before a machine stands behind it."""

import json

import pytest
from starlette.testclient import TestClient, WebSocketDenialResponse
from starlette.websockets import WebSocketDisconnect

from leadscrew.panel.app import application
from leadscrew.panel.audit import Audit
from leadscrew.panel.http_guard import Gate
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


BEARER = {"authorization": f"Bearer {TOKEN}"}


def panel(tmp_path, headers=BEARER, token=TOKEN):
    """A browser before the panel; ``headers``: how it says who it is."""
    link = NoMachine()
    gate = Gate("127.0.0.1", 8420, token)
    audit = Audit(tmp_path)
    hub = Hub(link, audit, 30.0)
    client = TestClient(application(hub, gate, tmp_path), base_url=f"http://{ADDRESS}", headers=headers)
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


def in_control(socket):
    said(socket, "hello", name="Ann", secret="a" * 16)
    said(socket, "take", 2)


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


EVERY = ["/", "/static/app.js", "/static/none.js", "/nothing", "/api/session.py", "/api/report.html",
         "/api/captures/a.csv", "/?token=wrong-token-012345678", f"/api/session.py?token={TOKEN}",
         f"/static/app.js?token={TOKEN}"]  # fmt: skip


@pytest.mark.parametrize("who", [{}, {"authorization": "Bearer wrong-token-012345678"}, {"cookie": "leadscrew_8420=1"}])
def test_who_has_not_opened_the_link_gets_nothing_but_the_sentence_what_to_do(tmp_path, who):
    client, link, audit = panel(tmp_path, who)
    with client:
        for path in EVERY:
            reply = client.get(path)
            assert reply.status_code == 401 and "open the link that leadscrew panel printed" in reply.text, path
            assert "set-cookie" not in reply.headers and reply.headers["referrer-policy"] == "no-referrer"
        ours = {"origin": f"http://{ADDRESS}"}
        assert client.post("/api/captures/a.csv", content=b"1,2", headers=ours).status_code == 401
        with pytest.raises(WebSocketDenialResponse) as refused, line(client):
            pass
        assert refused.value.status_code == 401 and "open the link" in refused.value.text
    log = (tmp_path / "audit.jsonl").read_text()
    assert link.asked == [] and "wrong-token" not in log and TOKEN not in log and len(errors(audit)) >= 10


def test_the_link_makes_a_browser_known_until_another_token_is_made(tmp_path):
    client, _, _ = panel(tmp_path, {})
    with client:
        typed = client.get(f"/?token={TOKEN}", headers={"sec-fetch-site": "none"}, follow_redirects=False)
        assert typed.status_code == 303 and typed.headers["location"] == "/"
        reply = client.get(f"/?token={TOKEN}", headers={"sec-fetch-site": "cross-site"})
        assert reply.headers["set-cookie"] == typed.headers["set-cookie"]
        assert reply.status_code == 200 and 'http-equiv="refresh" content="0; url=/"' in reply.text
        cookie = reply.headers["set-cookie"]
        assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= set(cookie.split("; ")) and TOKEN not in cookie
        assert reply.headers["referrer-policy"] == "no-referrer" and reply.headers["cache-control"] == "no-store"
        assert client.get("/").status_code == client.get("/static/app.js").status_code == 200
        assert client.get("/api/session.py").text == "text of the session"
        known = {"cookie": cookie.split(";")[0]}
        for name in ("Ann", "the second tab"):
            headers = {**HEADERS, **known}  # the client's own cookies are of another host where it opens a WebSocket
            with client.websocket_connect("/ws", subprotocols=["leadscrew.1"], headers=headers) as socket:
                assert said(socket, "hello", name=name)["ok"]
    with panel(tmp_path / "again", known)[0] as again:
        assert again.get("/").status_code == 200, "a panel with the same token file"
    with panel(tmp_path / "new", known, token="another-token-0123456789")[0] as new:
        assert new.get("/").status_code == 401


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
    with client, line(client) as ann:
        in_control(ann)
        ours = {"origin": f"http://{ADDRESS}", "leadscrew-secret": "a" * 16}
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


def test_only_the_page_in_control_sends_and_opens_captures(tmp_path):
    """A watcher could else fill the memory, and push out the captures of who works at the machine."""
    client, link, _ = panel(tmp_path)
    ours = {"origin": f"http://{ADDRESS}"}
    with client, line(client) as ann, line(client) as bob:
        said(ann, "hello", name="Ann", secret="a" * 16)
        said(bob, "hello", name="Bob", secret="b" * 16)
        for secret in (
            {},
            {"leadscrew-secret": ""},
            {"leadscrew-secret": "a" * 16},
            {"leadscrew-secret": b"\xff" * 16},
        ):
            reply = client.post("/api/captures/a.csv", content=b"x", headers={**ours, **secret})
            assert reply.status_code == 403 and "take control first" in reply.text
        said(ann, "take", 2)
        reply = client.post("/api/captures/a.csv", content=b"x", headers={**ours, "leadscrew-secret": "b" * 16})
        assert reply.status_code == 403 and "Ann has control" in reply.text
        assert "Ann has control" in said(bob, "capture_load", 3, name="a.csv")["error"]
        assert [a for a in link.asked if a[0] != "views"] == []
        assert said(ann, "capture_load", 3, name="a.csv")["ok"]
    reply = client.post("/api/captures/a.csv", content=b"x", headers={**ours, "leadscrew-secret": "a" * 16})
    assert reply.status_code == 403, "a page that is lost has no hand on the machine"


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
