"""Many runs: lanes side by side in the innermost loops, so that the compiler works on several runs at once.

Each stage of a period is a loop over lanes with the same step functions as the single run, on vectors that lie
on the stack: the compiler then knows that no store touches a rule table.
"""

from leadscrew.kernel.bits import stack_array2
from leadscrew.kernel.drivers import holes
from leadscrew.kernel.drivers.period import sample


def lanes(P, A, S, B, QA, ZB, places, values, span, select, Y, M, D):
    """Runs ``span[0]`` to ``span[1]`` (offset ``span[4]`` in the noise) for ``span[2]`` periods.

    Every ``span[3]`` periods are recorded, where anything is.

    ``values[v, run]`` replaces the number at ``places[v]`` of parameters, array parameters, state and array state laid
    end to end. ``QA`` and ``ZB`` are room for the array parameters and states of all lanes.
    ``D[run]`` becomes the period in which a run diverged, else it stays -1.
    """
    width = holes.LANES
    Q = stack_array2(holes.PARAMS, holes.LANES)
    Z = stack_array2(holes.STATES, holes.LANES)
    U = stack_array2(holes.DRIVES, holes.LANES)
    H = stack_array2(1, holes.LANES)
    R = stack_array2(holes.ROW, holes.LANES)
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
            holes.fill_params(QA, A, lane)
            holes.fill_states(ZB, B, lane)
            for v in range(places.shape[0]):
                place = places[v]
                if place < end_p:
                    Q[place, lane] = values[v, run]
                elif place < end_a:
                    holes.set_param(QA, place - end_p, lane, values[v, run])
                elif place < end_s:
                    Z[place - end_a, lane] = values[v, run]
                else:
                    holes.set_state(ZB, place - end_s, lane, values[v, run])
        qa = holes.param_views(QA)
        zb = holes.state_views(ZB)
        clock = holes.lane_params(Q, qa, 0).clock
        row = 0
        countdown = 0
        for k in range(periods):
            t = k * clock.period
            for lane in range(width):
                p = holes.lane_params(Q, qa, lane)
                s, x = sample(p, holes.lane_state(Z, zb, lane), t, k, span[4] + base + lane)
                holes.keep_lane(Z, lane, s)
                holes.keep_drive(U, lane, x.applied, x.load)
                H[0, lane] = 1.0 if holes.signals_sound(x, p.clock.bound) else 0.0
                if holes.RECORDING:
                    holes.keep_row(R, lane, x, s, t)
            if holes.RECORDING:
                if countdown == 0:
                    for c in range(select.shape[0]):
                        for lane in range(min(width, last - base)):
                            Y[base + lane, c, row] = R[select[c], lane]
                    row += 1
                    countdown = every
                countdown -= 1
            for j in range(clock.substeps):
                for lane in range(width):
                    p = holes.lane_params(Q, qa, lane)
                    s = holes.lane_state(Z, zb, lane)
                    u = holes.sent(s.sent, holes.lane_applied(U, lane), k, j, p.clock.substeps)
                    plant, memory = holes.plant_step(
                        p.plant, s.plant, s.integrator, u, holes.lane_load(U, lane),
                        k * p.clock.period + j * p.clock.step, p.clock.step,
                    )  # fmt: skip
                    holes.keep_lane_plant(Z, lane, plant, memory)
                    holes.watch(s.seen, p.plant, plant, k * p.clock.substeps + j + 1)
            for lane in range(width):
                s = holes.lane_state(Z, zb, lane)
                holes.keep_lane_plant(Z, lane, holes.settled(s.plant), s.integrator)
                H[0, lane] = H[0, lane] if holes.state_sound(s) else 0.0
            sound = 1.0
            for lane in range(width):
                sound = min(sound, H[0, lane])
            if sound < 0.5:
                for lane in range(min(width, last - base)):
                    if H[0, lane] < 0.5 and D[base + lane] < 0:
                        D[base + lane] = k
        for lane in range(min(width, last - base)):
            p = holes.lane_params(Q, qa, lane)
            holes.keep_metrics(M, base + lane, p, holes.lane_state(Z, zb, lane))
    return 0
