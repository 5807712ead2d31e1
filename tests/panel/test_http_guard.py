"""Who is let in: the address served, pages of this server, who opened its link."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from leadscrew.panel.http_guard import BURST, PER_S, Gate, Rate, is_loopback, new_token

TOKEN = "right-token-of-24-letters"
LOCAL = Gate("127.0.0.1", 8420, TOKEN)


def request(path="/", query=b"", method="GET", **headers):
    found = [(k.encode(), v if isinstance(v, bytes) else v.encode()) for k, v in headers.items()]
    return {"type": "http", "method": method, "path": path, "query_string": query, "headers": found}


@pytest.mark.parametrize("host", ["127.0.0.1:8420", "localhost:8420", "LOCALHOST:8420", "[::1]:8420"])
def test_the_panel_opens_under_every_name_of_this_computer(host):
    assert LOCAL.knows_host(host)
    assert LOCAL.knows_origin(f"http://{host}", host)


@pytest.mark.parametrize(
    "host", ["evil.example:8420", "127.0.0.1", "127.0.0.1:80", "", ":8420", "127.0.0.1:8420:8420",
             "127.0.0.1.evil:8420", "localhost:84200000", "localhost:-1",
             "10.0.0.7:8420", "[::1]", "127.0.0.1:８４２０"],
)  # fmt: skip
def test_a_name_that_somebody_else_points_here_is_refused(host):
    assert not LOCAL.knows_host(host)
    assert not LOCAL.knows_origin(f"http://{host}", host)


@pytest.mark.parametrize(
    "origin", ["", "null", "http://evil.example", "https://127.0.0.1:8420", "http://127.0.0.1:8421", "http://localhost:8420",
               "http://127.0.0.1:8420/", "file://"],
)  # fmt: skip
def test_a_page_of_another_server_is_refused(origin):
    assert not LOCAL.knows_origin(origin, "127.0.0.1:8420")


def test_on_all_addresses_numbers_are_known_and_foreign_names_are_not():
    everywhere = Gate("0.0.0.0", 8420, "t" * 20)
    assert everywhere.knows_host("192.168.1.5:8420") and everywhere.knows_host("localhost:8420")
    assert not everywhere.knows_host("evil.example:8420")
    named = Gate("192.168.1.5", 8420, "t" * 20)
    assert named.knows_host("192.168.1.5:8420") and not named.knows_host("192.168.1.6:8420")


def test_only_the_token_itself_is_the_token():
    gate = LOCAL
    assert gate.knows_token(TOKEN)
    for wrong in (
        None,
        "",
        "right-token-of-24-letter",
        "right-token-of-24-lettersx",
        "RIGHT-TOKEN-OF-24-LETTERS",
        "\ud800",
        "ä",
    ):
        assert not gate.knows_token(wrong)
        assert not Gate("127.0.0.1", 8420, "").knows_token(wrong), "no token is no way in"
    assert len({new_token() for _ in range(50)}) == 50 and len(new_token()) >= 30


@pytest.mark.parametrize(
    "query, opens",
    [(b"token=right-token-of-24-letters", True), (b"x=1&token=right%2Dtoken-of-24-letters", True),
     (b"", False), (b"token=", False), (b"token=wrong", False), (b"token=%ff%fe", False),
     (b"token=wrong&token=right-token-of-24-letters", False), ("token=ä".encode(), False)],
)  # fmt: skip
def test_the_link_opens_the_page_and_nothing_else(query, opens):
    assert LOCAL.opens(request(query=query)) is opens
    for other in (request("/api/session.py", query), request("/static/app.js", query),
                  request(query=query, method="POST"), {**request(query=query), "type": "websocket"}):  # fmt: skip
        assert not LOCAL.opens(other) and not LOCAL.admits(other)


def test_the_cookie_is_of_this_panel_and_its_token_and_does_not_hold_it():
    name, value = LOCAL.cookie
    assert TOKEN not in value and LOCAL.cookie == Gate("127.0.0.1", 8420, TOKEN).cookie, (
        "after a restart it still opens"
    )
    own = f"{name}={value}"
    for good in (own, f"theme=dark; {own}", f"{name}=old; {own}", f' {own} ;x="'):
        assert LOCAL.admits(request(cookie=good))
    for bad in ("", value, f"{name}=", f"{name}={TOKEN}", f"{name}={value}x", f"x{own}", f"{name}=\xff", b"\xff=\xff",
                "=".join(Gate("127.0.0.1", 8420, "another-token-0123456789").cookie)):  # fmt: skip
        assert not LOCAL.admits(request(cookie=bad))
    for other in (Gate("127.0.0.1", 8421, TOKEN), Gate("127.0.0.1", 8420, "")):
        assert not other.admits(request(cookie=own))
        assert other.cookie[0] != name or not other.token


def test_a_program_gives_the_token_in_a_header():
    for good in (f"Bearer {TOKEN}", f"bearer {TOKEN} "):
        assert LOCAL.admits(request(authorization=good))
    for bad in (TOKEN, f"Basic {TOKEN}", "Bearer", f"Bearer {TOKEN}x", b"Bearer \xff"):
        assert not LOCAL.admits(request(authorization=bad))


@given(st.binary(max_size=60))
def test_no_query_or_header_breaks_the_gate(data):
    assert not LOCAL.admits(request(authorization=data, cookie=data)) and not LOCAL.opens(request(query=data))
    text = data.decode("latin-1")
    assert not LOCAL.knows_origin(text, "127.0.0.1:8420") or text.lower() == "http://127.0.0.1:8420"


@pytest.mark.parametrize(
    "host, only_here", [("127.0.0.1", True), ("127.9.9.9", True), ("::1", True), ("localhost", True),
                        ("0.0.0.0", False), ("192.168.1.2", False), ("::", False), ("localhost.evil.example", False)],
)  # fmt: skip
def test_what_only_this_computer_reaches_is_known(host, only_here):
    assert is_loopback(host) == only_here


def test_a_flood_is_cut_to_what_a_person_can_do():
    rate = Rate(at=0.0)
    taken = sum(rate.takes(now=i * 1e-3) for i in range(10_000))
    assert taken == pytest.approx(BURST + 10 * PER_S, rel=0.01)
    calm = Rate(at=0.0)
    assert all(calm.takes(now=i / 50) for i in range(5000))


def test_a_page_that_sends_all_at_once_gets_its_burst_and_a_second_later_its_share():
    rate = Rate(at=0.0)
    assert sum(rate.takes(now=0.0) for _ in range(500)) == 120
    assert sum(rate.takes(now=1.0) for _ in range(500)) == 60
