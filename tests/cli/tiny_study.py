"""The smallest complete study: a step under proportional control, what a textbook says of it, and what else helps."""

from pathlib import Path

from leadscrew import Loop
from leadscrew.plants._linear import transfer_function
from leadscrew.references._step import step
from leadscrew.studies import Measured, Scenario, Study, Table, claim, contents_of, experiment, figure, measure
from leadscrew.studies.npid_xytable.tunings import table_pid


def build(controller, scenario):
    plant = transfer_function([1.0], [0.1, 1.0])
    return Loop(reference=step(target=1.0), controller=controller, plant=plant, period=0.001, engine="python")


@measure
def error_at_rest(lab, controller):
    return float(lab.run(controller, "step")["error"][-1])


@claim("(1)", says="0.100", unit="mm", basis="printed plant", key=True)
def proportional_error(lab):
    """Error at rest with a gain of 9, 1 / (1 + 9)"""
    return Measured(printed=error_at_rest(lab, "paper.p"), ours=error_at_rest(lab, "ours.pi"), note="ours <PI> & more")


@experiment("What does integral action change?")
def integral_action(lab):
    """The same step with a gain of 9 alone, and with an integral gain of 90 1/s."""
    rows = {name: (error_at_rest(lab, name), float("nan")) for name in STUDY.controllers}
    return Table("controller", ("error at rest (mm)", "settling (s)"), rows), "Integral action takes the error away."


@figure("The step with the <proportional> controller.", key=True)
def response(lab):
    return lab.run("paper.p", "step").plot()


def conclusion(lab):
    return [f"The error at rest is {error_at_rest(lab, 'paper.p'):.3f} mm & stays.", "A PI removes it."]


STUDY = Study(
    name="tiny", title="The error of a <proportional> controller", paper="A textbook.", build=build,
    controllers={"paper.p": table_pid(kp=9.0, ki=0.0, kd=0.0), "ours.pi": table_pid(kp=9.0, ki=90.0, kd=0.0)},
    scenarios={"step": Scenario("step", None, "a step of 1 mm", 0.5)},
    contents=contents_of(globals()), folder=Path(),
)  # fmt: skip
