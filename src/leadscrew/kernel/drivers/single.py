"""One run, from where the state vectors stand to a given period."""

from leadscrew.kernel.bits import stack_array2
from leadscrew.kernel.drivers import holes
from leadscrew.kernel.drivers.period import hold, sample


def single(P, A, S, B, counters, select, Y, M):
    """Advances one run.

    ``counters``: next period, end, record every, run, next row of ``Y``, diverged (0 or 1); updated in place.
    """
    p = holes.params_of(P, A)
    s = holes.state_of(S, B)
    R = stack_array2(holes.ROW, 1)
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
            holes.keep_row(R, 0, x, s, t)
            for c in range(select.shape[0]):
                Y[c, row] = R[select[c], 0]
            row += 1
            countdown = every
        countdown -= 1
        s = hold(p, s, x.applied, x.load, k)
        sound = holes.signals_sound(x, bound) & holes.state_sound(s)
        k += 1
    holes.keep_state(S, s)
    holes.keep_metrics(M, 0, p, s)
    counters[0] = k
    counters[4] = row
    counters[5] = 0 if sound else 1
    return 0
