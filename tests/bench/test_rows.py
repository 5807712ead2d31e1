"""What the bench makes of its measurements, with a clock that is known."""

import itertools

import pytest

from leadscrew.bench import threads
from leadscrew.bench.measuring import interleaved, repeated, row


def test_a_contender_s_time_is_the_median_of_its_turns_without_the_first_call():
    times = {"ours": iter((50.0, 1.0, 2.0, 90.0)), "theirs": iter((80.0, 4.0, 3.0, 5.0))}
    now, order = [0.0], []

    def call(name):
        order.append(name)
        now[0] += next(times[name])

    found = interleaved({n: lambda n=n: call(n) for n in times}, 3, lambda: now[0])
    assert found == {"ours": 2.0, "theirs": 4.0}
    assert order == ["ours", "theirs"] * 4


def test_a_call_is_repeated_as_often_as_asked():
    count = itertools.count()
    repeated(lambda: next(count), 7)()
    assert next(count) == 7


@pytest.mark.parametrize(
    ("bounds", "ratio", "passed", "target"),
    [
        ({"at_most": 1.5}, 1.5, True, "<= 1.5 x"), ({"at_most": 1.5}, 1.5000001, False, "<= 1.5 x"),
        ({"at_least": 1.7}, 1.7, True, ">= 1.7 x"), ({"at_least": 1.7}, 1.6999999, False, ">= 1.7 x"),
        ({"at_most": 20.0}, None, True, "<= 20 s"), ({}, 3.0, None, ""),
    ],
)  # fmt: skip
def test_a_target_is_met_at_its_very_limit(bounds, ratio, passed, target):
    found = row("a", "b", 20.0, "s", ratio=ratio, **bounds)
    assert (found["passed"], found["target"]) == (passed, target)


def test_two_threads_that_take_half_the_time_are_twice_as_fast(monkeypatch):
    monkeypatch.setattr(threads, "load", lambda: 0.0)
    monkeypatch.setattr(threads, "interleaved", lambda contenders, rounds, clock: {"1": 4.0, "2": 2.0})
    monkeypatch.setattr(threads.measuring, "batch", lambda *args, **more: None)
    one, two = threads.rows(1, 32, {})
    assert (one["value"], two["value"], two["ratio"], two["passed"]) == (8.0, 16.0, 2.0, True)
