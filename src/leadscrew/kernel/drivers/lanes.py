"""Many runs: lanes side by side in the innermost loops, so that the compiler works on several runs at once.

Each stage of a period is a loop over lanes with the same step functions as the single run, on vectors that lie
on the stack: the compiler then knows that no store touches a rule table.
"""

from __future__ import annotations

from leadscrew.kernel.bits import stack_array2
from leadscrew.kernel.drivers import hooks
from leadscrew.kernel.drivers.period import sample


def copy_lane(target, source, start, size, lane, width):
    """Copies one array into one lane."""
    for e in range(size):
        target[start * width + lane * size + e] = source[start + e]
    return 0


def set_lane(target, start, size, place, lane, width, value):
    """Sets one element of one array in one lane, where ``place`` falls into the array."""
    if place >= start and place < start + size:
        target[start * width + lane * size + place - start] = value
    return 0


def sound1(a):
    """Whether every element is finite."""
    sound = True
    for i in range(a.shape[0]):
        sound = sound & (abs(a[i]) <= 1.7976931348623157e308)
    return sound


def lanes(P, A, S, B, QA, ZB, places, values, span, select, Y, M, D):
    """Runs ``span[0]`` to ``span[1]`` (offset ``span[4]`` in the noise) for ``span[2]`` periods.

    Every ``span[3]`` periods are recorded, where anything is.

    ``values[v, run]`` replaces the number at ``places[v]`` of parameters, array parameters, state and array state laid
    end to end. ``QA`` and ``ZB`` are room for the array parameters and states of all lanes.
    ``D[run]`` becomes the period in which a run diverged, else it stays -1.
    """
    width = hooks.LANES
    Q = stack_array2(hooks.PARAMS, hooks.LANES)
    Z = stack_array2(hooks.STATES, hooks.LANES)
    U = stack_array2(hooks.DRIVES, hooks.LANES)
    H = stack_array2(1, hooks.LANES)
    R = stack_array2(hooks.ROW, hooks.LANES)
    end_p = P.shape[0]
    end_a = end_p + A.shape[0]
    end_s = end_a + S.shape[0]
    first = span[0]
    last = span[1]
    periods = span[2]
    every = span[3]
    for base in range(first, last, width):
        for lane in range(width):
            run = min(base + lane, last - 1)
            for q in range(P.shape[0]):
                Q[q, lane] = P[q]
            for q in range(S.shape[0]):
                Z[q, lane] = S[q]
            hooks.fill_params(QA, A, lane)
            hooks.fill_states(ZB, B, lane)
            for v in range(places.shape[0]):
                place = places[v]
                if place < end_p:
                    Q[place, lane] = values[v, run]
                elif place < end_a:
                    hooks.set_param(QA, place - end_p, lane, values[v, run])
                elif place < end_s:
                    Z[place - end_a, lane] = values[v, run]
                else:
                    hooks.set_state(ZB, place - end_s, lane, values[v, run])
        qa = hooks.param_views(QA)
        zb = hooks.state_views(ZB)
        clock = hooks.lane_params(Q, qa, 0).clock
        row = 0
        countdown = 0
        for k in range(periods):
            t = k * clock.period
            for lane in range(width):
                p = hooks.lane_params(Q, qa, lane)
                s, x = sample(p, hooks.lane_state(Z, zb, lane), t, k, span[4] + base + lane)
                hooks.keep_lane(Z, lane, s)
                hooks.keep_drive(U, lane, x.applied, x.load)
                H[0, lane] = 1.0 if hooks.signals_sound(x, p.clock.bound) else 0.0
                if hooks.RECORDING:
                    hooks.keep_row(R, lane, x, s, t)
            if hooks.RECORDING:
                if countdown == 0:
                    for c in range(select.shape[0]):
                        for lane in range(min(width, last - base)):
                            Y[base + lane, c, row] = R[select[c], lane]
                    row += 1
                    countdown = every
                countdown -= 1
            for j in range(clock.substeps):
                for lane in range(width):
                    p = hooks.lane_params(Q, qa, lane)
                    s = hooks.lane_state(Z, zb, lane)
                    u = hooks.sent(s.sent, hooks.lane_applied(U, lane), k, j, p.clock.substeps)
                    plant, memory = hooks.plant_step(
                        p.plant, s.plant, s.integrator, u, hooks.lane_load(U, lane),
                        k * p.clock.period + j * p.clock.step, p.clock.step,
                    )  # fmt: skip
                    hooks.keep_lane_plant(Z, lane, plant, memory)
                    hooks.watch(s.seen, p.plant, plant, k * p.clock.substeps + j + 1)
            for lane in range(width):
                s = hooks.lane_state(Z, zb, lane)
                hooks.keep_lane_plant(Z, lane, hooks.settled(s.plant), s.integrator)
                H[0, lane] = H[0, lane] if hooks.state_sound(s) else 0.0
            sound = 1.0
            for lane in range(width):
                sound = min(sound, H[0, lane])
            if sound < 0.5:
                for lane in range(min(width, last - base)):
                    if H[0, lane] < 0.5 and D[base + lane] < 0:
                        D[base + lane] = k
        for lane in range(min(width, last - base)):
            p = hooks.lane_params(Q, qa, lane)
            hooks.keep_metrics(M, base + lane, p, hooks.lane_state(Z, zb, lane))
    return 0
