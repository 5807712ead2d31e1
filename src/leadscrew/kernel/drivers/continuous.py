"""A loop without a control period: controller and plant are one continuous system under the adaptive integrator."""

from leadscrew.kernel.bits import stack_array2
from leadscrew.kernel.drivers import hooks
from leadscrew.kernel.drivers.rodas import rodas_advance


def observe(p, s, t):
    """Derivative of the controller's state, and the signals, at time ``t``."""
    dt = p.clock.period
    _, command = hooks.reference(p.reference, s.reference, t, dt, 0.0)
    _, load = hooks.disturbance(p.disturbance, s.disturbance, t, dt, 0.0)
    _, offset = hooks.output_disturbance(p.output_disturbance, s.output_disturbance, t, dt, 0.0)
    actual = hooks.disturbed(hooks.plant_output(p.plant, s.plant), offset)
    _, feedback = hooks.sensor(p.sensor, s.sensor, actual, t, dt, 0.0)
    rates, output = hooks.controller(p.controller, s.controller, command, feedback, t, dt)
    _, applied = hooks.actuator(p.actuator, s.actuator, output, t, dt)
    return rates, hooks.Signals(command, feedback, output, applied, actual, load)


def continuous_rates(p, s, u, load, t, x, f):
    """The derivative of controller and plant together."""
    s = hooks.gathered(s, x)
    rates, signals = observe(p, s, t)
    hooks.spread_rates(s, rates, hooks.derivative(p.plant, s.plant, signals.applied, signals.load, t), f)
    return 0


def continuous(P, A, S, B, counters, select, Y, M):
    """Advances one run; the clock's period is the interval between samples. Arguments as of ``single``."""
    p = hooks.params_of(P, A)
    s = hooks.state_of(S, B)
    R = stack_array2(hooks.ROW, 1)
    x = stack_array2(1, hooks.ORDER)
    k = counters[0]
    every = counters[2]
    row = counters[4]
    countdown = (every - k % every) % every if every > 0 else -1
    period = p.clock.period
    sound = True
    while k < counters[1] and sound:
        t = k * period
        _, signals = observe(p, s, t)
        metrics = hooks.metrics(
            p.metrics, s.metrics, signals.command, signals.actual, signals.feedback, signals.output, t, period
        )
        s = hooks.LoopState(
            s.reference, s.disturbance, s.output_disturbance, s.sensor, s.controller, s.actuator, s.plant, s.integrator,
            s.sent, s.seen, metrics,
        )  # fmt: skip
        if countdown == 0:
            hooks.keep_row(R, 0, signals, s, t)
            for c in range(select.shape[0]):
                Y[c, row] = R[select[c], 0]
            row += 1
            countdown = every
        countdown -= 1
        hooks.spread(s, x)
        h = s.integrator if s.integrator > 0.0 else period
        h = rodas_advance(p, s, 0.0, 0.0, t, period, x, h, hooks.RTOL, hooks.ATOL)
        s = hooks.remembered(hooks.gathered(s, x), h)
        sound = hooks.signals_sound(signals, p.clock.bound) & hooks.state_sound(s)
        k += 1
    hooks.keep_state(S, s)
    hooks.keep_metrics(M, 0, p, s)
    counters[0] = k
    counters[4] = row
    counters[5] = 0 if sound else 1
    return 0
