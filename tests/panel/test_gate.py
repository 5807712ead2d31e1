"""Who is let in: the address served, pages of this server, the token."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from leadscrew.panel.gate import BURST, PER_S, Gate, Rate, is_loopback, new_token

LOCAL = Gate("127.0.0.1", 8420)


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
    gate = Gate("0.0.0.0", 8420, "right-token-of-24-letters")
    assert gate.knows_token("right-token-of-24-letters")
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
    assert len({new_token() for _ in range(50)}) == 50 and len(new_token()) >= 30


@pytest.mark.parametrize(
    "headers, query, found",
    [([(b"authorization", b"Bearer abc")], b"", "abc"), ([], b"token=a%20b&x=1", None), ([], b"", None),
     ([(b"authorization", b"bearer abc ")], b"token=other", "abc"), ([(b"authorization", b"Basic abc")], b"", None)],
)  # fmt: skip
def test_a_download_gives_its_token_in_the_header_and_never_in_the_address(headers, query, found):
    assert LOCAL.token_of({"headers": headers, "query_string": query}) == found


@given(st.binary(max_size=60))
def test_no_query_or_header_breaks_the_gate(data):
    LOCAL.token_of({"headers": [(b"authorization", data)], "query_string": data})
    text = data.decode("latin-1")
    assert not LOCAL.knows_origin(text, "127.0.0.1:8420") or text.lower() == "http://127.0.0.1:8420"


@pytest.mark.parametrize(
    "host, only_here", [("127.0.0.1", True), ("127.9.9.9", True), ("::1", True), ("localhost", True),
                        ("0.0.0.0", False), ("192.168.1.2", False), ("::", False), ("localhost.evil.example", False)],
)  # fmt: skip
def test_what_only_this_computer_reaches_needs_no_token(host, only_here):
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
