"""The sense of a plant's drive is the way in which its output moves."""

import warnings
from typing import NamedTuple

import pytest

from leadscrew import Loop, catalogue, controller, resolve
from leadscrew.kernel.layout import is_branch
from leadscrew.references._step import step
from tests.cli.conftest import call  # noqa: F401

SECONDS = 0.2


class Push(NamedTuple):
    size: float = 0.5


@controller(Push())
def push(p, feedback):
    return p.size


def moved(block, period=0.001, load=None):
    """How far a plant's first output goes under a constant input, less the way that it goes under none."""

    def end(size):
        loop = Loop(
            reference=step(), controller=push(size=size), plant=block, disturbance=load, period=period, engine="python"
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            run = loop.run(SECONDS if period < 0.01 else 20 * period, ["actual"])
        return run["actual"][-1]

    return end(0.5) - end(0.0)


def plants_of(name):
    study = resolve.study(name)
    first = next(iter(study.controllers))
    loops = [study.loop(first, scenario) for scenario in study.scenarios]
    return {loop.blocks["plant"].name: loop for loop in loops}


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(catalogue.study_names()))
def test_a_positive_input_moves_every_machine_of_a_study_as_its_sense_says(name):
    for plant_name, loop in plants_of(name).items():
        block = loop.blocks["plant"]
        if is_branch(loop.signals["applied"]):
            continue  # several drives: each has its own way
        way = moved(block, loop.period, loop.blocks["disturbance"])
        assert way != 0.0 and (way > 0.0) == (block.sense > 0), (plant_name, way)


@pytest.mark.parametrize("name", ["lathe_servo", "lathe_screw", "lathe_servo_limited"])
def test_the_lathe_moves_towards_negative_positions(name):
    block = resolve.block(name, "plant")
    assert block.sense == -1 and moved(block) < 0.0


@pytest.mark.slow
def test_the_list_of_a_reversed_plant_says_so(call):  # noqa: F811
    assert "a positive input moves its output towards negative values" in call("list", "lathe_servo").stdout
    assert "sense" not in call("list", "servo_axis").stdout


@pytest.mark.slow
def test_the_list_of_a_study_names_its_reversed_machines(call):  # noqa: F811
    import json

    text = " ".join(call("list", "vud_lathe").stdout.split())
    assert "a positive input moves lathe_servo, lathe_screw, lathe_servo_limited towards negative values" in text
    senses = {p["name"]: p["sense"] for p in json.loads(call("list", "vud_lathe", "--json").stdout)["plants"]}
    assert senses == {"lathe_servo": -1, "lathe_screw": -1, "lathe_servo_limited": -1}
    assert "sense of the drive" not in call("list", "npid_xytable").stdout
