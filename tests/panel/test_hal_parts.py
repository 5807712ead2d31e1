"""The process at HAL, piece by piece: lost periods keep their place, and a thread is touched only while it sleeps."""

from __future__ import annotations

import itertools
import os

import pytest

from leadscrew.panel.hal import attached
from leadscrew.panel.hal.attached import Fifo


class Stream:
    """A FIFO of sampler: what finds it full is lost and, as in LinuxCNC 2.9, has no number; or has one."""

    def __init__(self, depth, numbered):
        self.maxdepth, self.numbered = depth, numbered
        self.rows, self.number, self.num_overruns, self.sampleno = [], 0, 0, 0

    def write(self, value):
        if len(self.rows) == self.maxdepth - 1:
            self.num_overruns += 1
            self.number += self.numbered
            return
        self.number += 1
        self.rows.append((self.number, value))

    @property
    def readable(self):
        return bool(self.rows)

    def read(self):
        self.sampleno, value = self.rows.pop(0)
        return [value]


class Hal:
    sampler_base = 0

    def __init__(self, stream):
        self.made = stream

    def stream(self, component, key, kinds):
        return self.made


@pytest.mark.parametrize("numbered", [0, 1])
def test_every_row_has_the_number_of_its_period_however_many_were_lost_before(numbered):
    stream = Stream(50, numbered)
    fifo = Fifo(Hal(stream), None, 0, "f", [0])
    period, found = itertools.count(), []
    for written in (20, 130, 3, 49, 50, 51, 1, 400, 10):
        for _ in range(written):
            stream.write(float(next(period)))
        found += fifo.fetch()
    rows = [(first + i, value) for first, values in found for i, value in enumerate(values)]
    assert all(number == value for number, value in rows)
    lost = 130 - 49 + 1 + 2 + 400 - 49
    assert len(rows) == next(period) - lost


def test_a_thread_is_touched_only_while_it_sleeps(tmp_path, monkeypatch):
    ticks, states = itertools.count(), iter([b"R", b"R", b"R", *[b"S"] * 9])
    stat = tmp_path / "stat"
    stat.write_bytes(b"")

    class Ticking:
        def get_value(self, name):
            return next(ticks)

    monkeypatch.setattr(attached, "sleepers", lambda: [os.open(stat, os.O_RDONLY)])
    monkeypatch.setattr(os, "pread", lambda *words: b"13 (rtapi_app:T#0) " + next(states) + b" 1 2")
    assert attached.in_pause(Ticking(), "servo", 1.0, lambda: 7) == 7
    assert next(states) == b"S" and len(list(states)) == 7
    monkeypatch.setattr(os, "pread", lambda *words: b"13 (rtapi_app:T#0) R 1 2")
    monkeypatch.setattr(attached, "PATIENCE_S", 0.05)
    with pytest.raises(attached.NoPause):
        attached.in_pause(Ticking(), "servo", 1.0, lambda: 7)
