"""One run from where the state vectors stand: to a given period, or period by period without its controller.

``read`` and ``write`` are the two halves of a period: what the machine shows, then what the machine is told.
"""

from __future__ import annotations

from leadscrew.kernel.bits import stack_array2
from leadscrew.kernel.drivers import hooks
from leadscrew.kernel.drivers.period import act, hold, sample, sense


def single(P, A, S, B, counters, select, Y, M):
    """Advances one run.

    ``counters``: next period, end, record every, run, next row of ``Y``, diverged (0 or 1); updated in place.
    """
    p = hooks.params_of(P, A)
    s = hooks.state_of(S, B)
    R = stack_array2(hooks.ROW, 1)
    start = counters[0]
    end = counters[1]
    every = counters[2]
    run = counters[3]
    row = counters[4]
    countdown = (every - start % every) % every if every > 0 else -1
    period = p.clock.period
    bound = p.clock.bound
    k = start
    sound = True
    while k < end and sound:
        t = k * period
        s, x = sample(p, s, t, k, run)
        if countdown == 0:
            hooks.keep_row(R, 0, x, s, t)
            for c in range(select.shape[0]):
                Y[c, row] = R[select[c], 0]
            row += 1
            countdown = every
        countdown -= 1
        s = hold(p, s, x.applied, x.load, k)
        sound = hooks.signals_sound(x, bound) & hooks.state_sound(s)
        k += 1
    hooks.keep_state(S, s)
    hooks.keep_metrics(M, 0, p, s)
    counters[0] = k
    counters[4] = row
    counters[5] = 0 if sound else 1
    return 0


def read(P, A, S, B, X, counters):
    """The start of period ``counters[0]``: command, feedback and load into ``X``."""
    p = hooks.params_of(P, A)
    s, command, feedback, _, load = sense(p, hooks.state_of(S, B), counters[0] * p.clock.period, counters[0], 0)
    hooks.keep_sensed(X, command, feedback, load)
    hooks.keep_state(S, s)
    return 0


def write(P, A, S, B, X, counters):
    """The rest of the period under the output that stands in ``X``; the next period follows."""
    p = hooks.params_of(P, A)
    k = counters[0]
    s, applied = act(p, hooks.state_of(S, B), hooks.given_output(X), k * p.clock.period, k)
    hooks.keep_state(S, hold(p, s, applied, hooks.given_load(X), k))
    counters[0] = k + 1
    return 0
