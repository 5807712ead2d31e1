"""Options by name: in Python, in loops and batches, and of every block of the catalogue."""

import math
from dataclasses import replace
from typing import Annotated, Literal, NamedTuple

import numpy as np
import pytest

from leadscrew import catalogue, resolve
from leadscrew.controllers._pid import PIDParams, pid
from leadscrew.kernel.block import disturbance
from leadscrew.kernel.parameters import Doc, entries
from leadscrew.references._step import step
from leadscrew.util.errors import BlockError, ValueRefused
from tests.controllers.xy_loop import xy_loop


class WaveParams(NamedTuple):
    shape: Annotated[Literal["sine", "square"] | int, Doc("shape of a period")] = 0
    reversed: Annotated[Literal["off", "on"] | int, Doc("turned over")] = 0


@disturbance(WaveParams())
def wave(p, t):
    angle = math.sin(2.0 * math.pi * 20.0 * t)
    high = angle if p.shape == 0 else (1.0 if angle >= 0.0 else -1.0)
    return -high if p.reversed == 1 else high


def pushed(block=wave):
    return xy_loop(pid(lower=-5.0, upper=5.0), step(target=1.0), disturbance=block)


def shapes(block):
    return pushed(block).run(0.05, record="disturbance")["disturbance"]


def test_a_name_is_what_the_step_compares_with_its_number():
    sine = np.sin(2.0 * np.pi * 20.0 * np.arange(100) * 5e-4)
    assert shapes(wave) == pytest.approx(sine, abs=1e-12)
    assert shapes(wave(shape="square"))[1:50].tolist() == [1.0] * 49
    assert shapes(wave(shape="square", reversed=True))[1:50].tolist() == [-1.0] * 49


@pytest.mark.parametrize("value", ["square", 1, 1.0, np.int64(1)])
def test_a_name_and_the_number_of_before_mean_the_same(value):
    assert wave(shape=value).params == WaveParams(1) and type(wave(shape=value).params.shape) is int


@pytest.mark.parametrize("value", ["squared", "1", 2, -1, 0.5, math.nan, True, None, [1], np.zeros(2)])
def test_no_such_option_is_refused_with_the_names(value):
    with pytest.raises(ValueRefused, match=r"^shape = .* \(wave\): there are sine, square(; did you mean square\?)?$"):
        wave(shape=value)


def test_a_loop_shows_names_and_takes_them():
    loop = pushed().using({"disturbance.shape": "square"})
    assert loop.parameters["disturbance.shape"] == "square" and loop.parameters["disturbance.reversed"] == "off"
    assert loop.program is pushed().using({"disturbance.shape": 1}).program
    with pytest.raises(ValueRefused, match=r"disturbance.shape = 'sin': there are sine, square; did you mean sine\?"):
        loop.using({"disturbance.shape": "sin"})
    live = loop.start()
    live.set("disturbance.reversed", "on")
    assert live.loop.parameters["disturbance.reversed"] == "on" and live.loop.manifest("llvm")["parameters"] == {
        **pushed().parameters, "disturbance.shape": "square", "disturbance.reversed": "on"
    }  # fmt: skip


@pytest.mark.parametrize("engine", ["llvm", "python"])
def test_a_batch_takes_names_and_numbers_and_gives_the_single_runs(engine):
    loop, names = pushed(), ["sine", "square", "square"]
    for values in (names, np.array([0.0, 1.0, 1.0])):
        batch = loop.batch(0.02, {"disturbance.shape": values}, record="disturbance", engine=engine)
        for name, row in zip(names, batch["disturbance"], strict=True):
            alone = loop.using({"disturbance.shape": name}).run(0.02, record="disturbance")
            assert np.array_equal(row, alone["disturbance"])
    grid = loop.sweep(
        0.02, {"disturbance.shape": ["sine", "square"], "controller.kp": [1.0, 2.0]}, record="disturbance"
    )
    assert np.array_equal(grid["disturbance"][2], batch["disturbance"][1])
    with pytest.raises(ValueRefused, match="there are sine, square"):
        loop.batch(0.02, {"disturbance.shape": ["sine", "round"]})


def test_a_name_put_past_the_checks_into_a_namedtuple_is_refused_where_the_loop_is_built():
    block = replace(pid, params=PIDParams(anti_windup="clamping"))
    with pytest.raises(BlockError, match=r"anti_windup = 'clamping' \(PIDParams\).*pid\(anti_windup='clamping'\)"):
        xy_loop(block, step(target=1.0))


def choices():
    blocks = {name: resolve.block(name) for name in catalogue.block_names()}
    return [(name, e.key) for name, block in blocks.items() for e in entries(block.params) if e.choice is not None]


def test_the_options_of_the_usual_blocks_have_the_words_of_the_field():
    sheet = {(n, e.key): e.choice.names for n in ("pid", "tfc") for e in entries(resolve.block(n).params) if e.choice}
    assert sheet["pid", "anti_windup"] == ("none", "clamping", "back-calculation")
    assert sheet["tfc", "inference"] == ("product", "minimum")


@pytest.mark.sweep
@pytest.mark.parametrize(("name", "key"), choices())
def test_every_option_of_the_catalogue_is_set_by_its_name_and_shown_by_it(name, key):
    block = resolve.block(name)
    (choice,) = (e.choice for e in entries(block.params) if e.key == key)
    assert len(set(choice.names)) == len(choice.names) > 1
    for number, option in enumerate(choice.names):
        set_ = block(**{key: option})
        shown = {e.key: e for e in entries(set_.params)}[key]
        assert shown.default == option and shown.stored(option) == number and shown.check(number) == option
        assert block(**{key: number}).params == set_.params or any(isinstance(v, np.ndarray) for v in set_.params)
