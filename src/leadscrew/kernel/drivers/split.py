"""A loop without its controller, in two calls a period: what the machine shows, then what the machine is told."""

from leadscrew.kernel.drivers import holes
from leadscrew.kernel.drivers.period import act, hold, sense


def read(P, A, S, B, X, counters):
    """The start of period ``counters[0]``: command, feedback and load into ``X``."""
    p = holes.params_of(P, A)
    s, command, feedback, _, load = sense(p, holes.state_of(S, B), counters[0] * p.clock.period, counters[0], 0)
    holes.keep_sensed(X, command, feedback, load)
    holes.keep_state(S, s)
    return 0


def write(P, A, S, B, X, counters):
    """The rest of the period under the output that stands in ``X``; the next period follows."""
    p = holes.params_of(P, A)
    k = counters[0]
    s, applied = act(p, holes.state_of(S, B), holes.given_output(X), k * p.clock.period, k)
    holes.keep_state(S, hold(p, s, applied, holes.given_load(X), k))
    counters[0] = k + 1
    return 0
