"""Simulated time keeps to wall time, and a slow computer never ends in a spiral."""

import pytest

from leadscrew.panel.pacing import Pacer


def driven(pacer, seconds, cost_s, tick_s=0.02, jitter=0.0):
    """Ticks as the process makes them, where a period costs ``cost_s``; simulated s, and the longest tick."""
    now, done, longest, n = 100.0, 0, 0.0, 0
    pacer.due(now)
    while now < 100.0 + seconds:
        n += 1
        now += tick_s + jitter * (n % 3)
        periods = pacer.due(now)
        wall = periods * cost_s + 2e-4
        pacer.spent(periods, wall)
        longest = max(longest, wall)
        done += periods
        now += max(0.0, wall - tick_s)
    return done * pacer.period_s, longest


@pytest.mark.parametrize("speed", [0.001, 0.05, 1.0, 20.0])
def test_time_runs_at_the_speed_that_was_set(speed):
    pacer = Pacer(1e-3)
    pacer.speed = speed
    simulated, longest = driven(pacer, 20.0, 1e-6, jitter=0.004)
    assert simulated == pytest.approx(20.0 * speed, rel=0.03, abs=2e-3)
    assert longest < 0.02 and not pacer.behind(120.0)


def test_where_the_computer_is_too_slow_time_is_dropped_and_said():
    pacer = Pacer(1e-3)
    simulated, longest = driven(pacer, 20.0, 2e-3)
    assert 5.0 < simulated < 10.5
    assert longest < 0.14, "a tick may not hold the machine up"
    assert pacer.behind(120.0)


def test_after_a_hitch_only_a_quarter_of_a_second_is_made_up():
    pacer = Pacer(1e-3)
    driven(pacer, 1.0, 1e-6)
    last = pacer._last
    made_up = sum(pacer.due(last + 5.0 + 0.02 * i) for i in range(1, 50))
    assert made_up == pytest.approx(250 + 980, abs=25)
    assert pacer.behind(last + 5.1) and not pacer.behind(last + 7.0)


def test_time_on_hold_is_not_made_up():
    pacer = Pacer(1e-3)
    pacer.due(0.0)
    assert pacer.due(0.1) == pytest.approx(100, abs=40)
    pacer.pause()
    assert pacer.due(60.0) == 0 and pacer.due(60.02) <= 20


def test_from_slow_motion_to_fast_it_catches_on_within_a_second():
    pacer = Pacer(2.5e-4)
    pacer.speed = 0.01
    driven(pacer, 5.0, 2e-6)
    pacer.speed = 20.0
    pacer.pause()
    simulated, _ = driven(pacer, 2.0, 2e-6)
    assert simulated > 36.0
