"""A workplace with controllers installed in it, for the tests of the HAL target."""

from pathlib import Path

import numpy as np

from leadscrew.export import hal_check, hal_run
from leadscrew.export.hal_check import Stream
from tests.export import hal_sample
from tests.tools import missing

PINS = ("command", "command-deriv", "feedback")


def needed():
    """Skips, or fails where it is required, on a machine that cannot run HAL."""
    why = hal_run.lacking()
    if why:
        missing("linuxcnc", why)


class Bench:
    """Controllers that are installed among the modules of one workplace."""

    def __init__(self, place, folder):
        self.place = place
        self.cores = {}
        for core in (
            hal_sample.core("demo_down", sense=-1),
            hal_sample.core("demo_up", sense=1),
            hal_sample.core("demo_single", sense=-1, real="float"),
            hal_sample.core("demo_any", rediscretisable=True),
        ):
            hal_run.install(place, hal_sample.export(core, folder / core.name, rows=10), core.name)
            self.cores[core.name] = core

    def stream(self, name, inputs, **more):
        """What a component makes of the rows of a record's inputs."""
        return self.replay(name, {pin: inputs[:, i] for i, pin in enumerate(PINS)}, **more)

    def replay(self, name, inputs, **more):
        """What a component makes of inputs by pin."""
        return hal_check.replay(self.place, hal_sample.manifest(self.cores[name]), Stream(inputs, **more))

    def record(self, name, rows=1000):
        """Inputs, and the outputs that the machine should get."""
        recorded = hal_sample.record(self.cores[name], rows)
        return recorded.inputs, self.cores[name].machine_outputs(recorded)

    def sampled(self, lines, pins, rows, after=()):
        """Values of pins by period after the thread has started, and what was printed."""
        taken, reader = self.place / "sampled.bin", self.place / "reader.py"
        reader.write_bytes(Path(hal_run.__file__).with_name("hal_reader.py").read_bytes())
        kinds = "f" * len(pins)
        script = [
            "loadrt threads name1=servo period1=1000000",
            f"loadrt sampler depth={rows + 10} cfg={kinds}",
            *lines,
            "addf sampler.0 servo",
            *(f"net sampled{i} {pin} => sampler.0.pin.{i}" for i, pin in enumerate(pins)),
            "start",
            f"loadusr -w {hal_run.PYTHON} {reader} {rows} {kinds} {taken}",
            *after,
        ]
        text = hal_run.run(self.place, "\n".join(script) + "\n")
        return np.fromfile(taken).reshape(-1, len(pins)), shown(text)

    def loop(self, load, instance, function, setup=(), gain=100.0, after=()):
        """Feedback and output of a loop around an integrating plant of stock HAL, and what was printed."""
        lines = [
            load,
            "loadrt integ names=plant",
            f"addf {function} servo",
            "addf plant servo",
            f"net sampled0 plant.out => {instance}.feedback",
            f"net sampled1 {instance}.output => plant.in",
            f"setp plant.gain {gain}",
            f"setp {instance}.command 1",
            f"setp {instance}.enable 1",
            *setup,
        ]
        table, text = self.sampled(lines, ["plant.out", f"{instance}.output"], 500, after)
        return table[:, 0], table[:, 1], text


def shown(text):
    """What was printed, with single spaces."""
    return " ".join(text.split())
