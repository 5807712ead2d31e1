"""One control period: sample everything at its start, then hold the controller's output over the plant."""

from leadscrew.kernel.drivers import hooks
from leadscrew.kernel.noise import Noise


def sense(p, s, t, k, run):
    """The first half of a period: the loop's state with reference, disturbances and sensor moved on, and what they say.

    Returns:
        state, command, feedback, true output, load.
    """
    dt = p.clock.period
    seed = p.clock.seed
    reference, command = hooks.reference(p.reference, s.reference, t, dt, Noise(seed, run, 0, k))
    disturbance, load = hooks.disturbance(p.disturbance, s.disturbance, t, dt, Noise(seed, run, 1, k))
    output_disturbance, offset = hooks.output_disturbance(
        p.output_disturbance, s.output_disturbance, t, dt, Noise(seed, run, 2, k)
    )
    shown = hooks.plant_output(p.plant, s.plant)
    actual = hooks.disturbed(shown, offset)
    measured = hooks.disturbed(hooks.seen(s.seen, shown, k, p.clock.substeps), offset)
    sensor, feedback = hooks.sensor(p.sensor, s.sensor, measured, t, dt, Noise(seed, run, 3, k))
    state = hooks.LoopState(
        reference, disturbance, output_disturbance, sensor, s.controller, s.actuator, s.plant, s.integrator, s.sent,
        s.seen, s.metrics,
    )  # fmt: skip
    return state, command, feedback, actual, load


def act(p, s, output, t, k):
    """The second half: the loop's state with the actuator moved on, and what goes to the plant."""
    actuator, applied = hooks.actuator(p.actuator, s.actuator, output, t, p.clock.period)
    hooks.send(s.sent, applied, k)
    state = hooks.LoopState(
        s.reference, s.disturbance, s.output_disturbance, s.sensor, s.controller, actuator, s.plant, s.integrator,
        s.sent, s.seen, s.metrics,
    )  # fmt: skip
    return state, applied


def sample(p, s, t, k, run):
    """The loop's next state but for the plant's, and the signals of period ``k``."""
    dt = p.clock.period
    sensed, command, feedback, actual, load = sense(p, s, t, k, run)
    controller, output = hooks.controller(p.controller, s.controller, command, feedback, t, dt)
    acted, applied = act(p, sensed, output, t, k)
    metrics = hooks.metrics(p.metrics, s.metrics, command, actual, feedback, output, t, dt)
    state = hooks.LoopState(
        acted.reference, acted.disturbance, acted.output_disturbance, acted.sensor, controller, acted.actuator, s.plant,
        s.integrator, s.sent, s.seen, metrics,
    )  # fmt: skip
    return state, hooks.Signals(command, feedback, output, applied, actual, load)


def hold(p, s, applied, load, k):
    """The loop's state after the plant has moved through period ``k``."""
    plant = s.plant
    memory = s.integrator
    step = p.clock.step
    substeps = p.clock.substeps
    for j in range(substeps):
        u = hooks.sent(s.sent, applied, k, j, substeps)
        plant, memory = hooks.plant_step(p.plant, plant, memory, u, load, k * p.clock.period + j * step, step)
        hooks.watch(s.seen, p.plant, plant, k * substeps + j + 1)
    return hooks.LoopState(
        s.reference, s.disturbance, s.output_disturbance, s.sensor, s.controller, s.actuator, hooks.settled(plant),
        memory, s.sent, s.seen, s.metrics,
    )  # fmt: skip
