"""What a page is sent of the signals: nothing lost of minimum and maximum, and never too much."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from leadscrew.panel.backfill import Backfill
from leadscrew.panel.frames import HEADER, LIVE, ROWS_PER_S, Frame, Thinner


def pieces(rows, cuts):
    edges = sorted({0, len(rows), *(c % (len(rows) + 1) for c in cuts)})
    return [(a, rows[a:b]) for a, b in pairwise(edges)]


def run(rows, cuts, rate):
    thinner = Thinner(LIVE, 3)
    assert thinner.pace(rate) == []
    found = [f for first, part in pieces(rows, cuts) for f in thinner.feed(first, part)]
    return found, found + thinner.flush()


@given(
    st.integers(1, 400), st.lists(st.integers(0, 1000), max_size=20), st.sampled_from([100.0, 2001.0, 4000.0, 80_000.0])
)
def test_pairs_are_the_minimum_and_maximum_of_their_periods_however_rows_come(count, cuts, rate):
    rows = np.random.default_rng(count).normal(size=(count, 3))
    whole, found = run(rows, cuts, rate)
    seen = 0
    for frame in found:
        assert frame.first == seen
        step = round(2 * frame.stride)
        if frame.stride == 1.0:
            np.testing.assert_array_equal(frame.rows, rows[seen : seen + len(frame.rows)].astype(np.float32))
            seen += len(frame.rows)
            continue
        for low, high in frame.rows.reshape(-1, 2, 3):
            part = rows[seen : seen + step].astype(np.float32)
            np.testing.assert_array_equal(low, part.min(axis=0))
            np.testing.assert_array_equal(high, part.max(axis=0))
            seen += step
    assert seen == count
    assert sum(len(f.rows) for f in whole) <= max(count * ROWS_PER_S / rate, 0) + 1 if rate > ROWS_PER_S else True


def test_a_spike_of_one_period_is_seen_at_twenty_times_real_time():
    rows = np.zeros((8000, 1))
    rows[4321] = 5.0
    _, found = run(rows, [1600, 3200], 80_000.0)
    assert max(f.rows.max() for f in found) == 5.0


def test_a_frame_is_what_the_page_reads():
    frame = Frame(LIVE, 7, 12.0, 2.0, np.array([[1.0, 2.0, 1e300], [3.0, np.nan, -4.0]]))
    with np.errstate(over="ignore"):
        data = frame.encode()
    assert HEADER.size == 32 and data[:2] == b"\x01\x01"
    assert HEADER.unpack_from(data) == (1, 1, 3, 2, 7, 0, 12.0, 2.0)
    values = np.frombuffer(data, "<f4", offset=32).reshape(2, 3)
    np.testing.assert_array_equal(values, np.array([[1, 2, np.inf], [3, np.nan, -4]], dtype=np.float32))
    assert len(Frame(3, 1, 0, 1, np.zeros((5, 2))).encode()) == 32 + 80


def test_a_change_of_speed_loses_no_row():
    thinner = Thinner(LIVE, 1)
    thinner.pace(80_000.0)
    rows = np.arange(33.0)[:, None]
    found = thinner.feed(0, rows) + thinner.pace(100.0) + thinner.feed(33, np.arange(33.0, 40.0)[:, None])
    assert found[0].rows.min() == 0 and max(f.rows.max() for f in found) == 39
    assert [f.first for f in found] == sorted(f.first for f in found)


def frame(first, rows, kind=1, stride=1.0, columns=2):
    return Frame(kind, 1, first, stride, np.full((rows, columns), float(first))).encode()


def test_a_page_that_comes_back_gets_what_it_missed_in_few_pieces():
    ring = Backfill()
    for i in range(100):
        ring.add(frame(20 * i, 20), now=0.02 * i)
        ring.add(frame(20 * i, 20, kind=2), now=0.02 * i)
    found = ring.since(995.0)
    assert len(found) == 2 and [f[1] for f in found] == [1, 2]
    head = HEADER.unpack_from(found[0])
    assert head[6] == 980 and head[3] == 2000 - 980 and len(found[0]) == 32 + 8 * head[3]
    assert ring.since(1e9) == [] and sum(HEADER.unpack_from(f)[3] for f in ring.since(None)) == 4000


def test_a_gap_or_another_stride_is_never_joined_over():
    ring = Backfill()
    for f in (frame(0, 20), frame(20, 20), frame(60, 20), frame(80, 20, stride=2.0)):
        ring.add(f, now=0.0)
    heads = [HEADER.unpack_from(f) for f in ring.since(None)]
    assert [(h[3], h[6], h[7]) for h in heads] == [(40, 0, 1), (20, 60, 1), (20, 80, 2)]


def test_the_ring_holds_a_minute_and_is_bounded():
    ring = Backfill()
    for i in range(5000):
        ring.add(frame(20 * i, 20), now=0.02 * i)
    rows = sum(HEADER.unpack_from(f)[3] for f in ring.since(None))
    assert rows == pytest.approx(60_000, rel=0.01)
    for _ in range(200):
        ring.add(frame(0, 1000, columns=200), now=100.0)
    assert ring._bytes <= 24_000_000
    ring.clear()
    assert ring.since(None) == []
