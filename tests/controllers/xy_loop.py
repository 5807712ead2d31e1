"""The digital reference loop of the XY table: 2 kHz, 25 us steps, 0.775 ms from sample to output."""

from leadscrew.kernel.loop import Loop
from leadscrew.plants._xy_table import xy_table

PERIOD = 0.5e-3


def xy_loop(controller, reference, **more):
    return Loop(
        reference=reference,
        controller=controller,
        plant=xy_table,
        period=PERIOD,
        substeps=20,
        computation_delay=0.775e-3,
        metrics={},
        **more,
    )


def outputs(block, commands, feedbacks, dt=PERIOD):
    """What a controller's step gives, called by hand."""
    s, seen = block.state, []
    for command, feedback in zip(commands, feedbacks, strict=True):
        s, u = block.step(block.params, s, float(command), float(feedback), dt)
        seen.append(u)
    return seen
