"""Stiff plants: what integrates them unless a method is named, and what a manifest says of it."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew import Loop, catalogue, controller, plant, resolve
from leadscrew.kernel.frame import as_floats
from leadscrew.kernel.layout import Layout
from leadscrew.plants._mass_lugre import mass_lugre
from leadscrew.references._sine import sine
from leadscrew.references._step import step
from leadscrew.util.errors import BlockError, ValueRefused
from tests.kernel import zoo

PERIOD = 0.75e-3


@controller()
def through(command, feedback):
    return command


class PIState(NamedTuple):
    integral: float = 0.0


@controller(None, PIState(), continuous=True)
def continuous_pi(s, command, feedback):
    return PIState(command - feedback), 2.0 * (command - feedback) + s.integral


def pushed(**options):
    """A mass under LuGre friction, pushed by 5 N from rest: it slides at 0.2 m/s after 50 ms."""
    return Loop(reference=step(target=5.0), controller=through, plant=mass_lugre, period=PERIOD, metrics={}, **options)


def lugre(t, x):
    """Canudas de Wit et al. (1995), equations (2) to (5) and Table I, unit mass, written anew."""
    _, v, z = x
    g = (1.0 + 0.5 * np.exp(-((v / 0.001) ** 2))) / 1e5
    rate = v - abs(v) * z / g
    return [v, 5.0 - (1e5 * z + np.sqrt(1e5) * rate + 0.4 * v), rate]


def test_a_mass_with_bristles_does_not_diverge_and_follows_an_independent_solver():
    run = pushed().run(67 * PERIOD, engine="python")
    truth = solve_ivp(lugre, (0.0, 66 * PERIOD), [0.0] * 3, "Radau", rtol=1e-9, atol=1e-14).y[0, -1]
    assert run.diverged is None
    assert run["actual"][-1] == pytest.approx(truth, rel=1e-5)


@pytest.mark.filterwarnings("ignore::leadscrew.kernel.loop.DivergenceWarning")
def test_the_method_that_a_user_names_is_the_one_that_runs():
    named = pushed(method="rk4")
    assert named.integration == {"method": "rk4", "substeps": 1, "rtol": None, "atol": None}
    assert named.run(0.05, engine="python").diverged is not None, "explicit steps of 0.75 ms are too long for bristles"


@pytest.mark.slow
def test_single_runs_and_batches_of_a_stiff_loop_have_the_same_bits_and_name_the_method():
    loop = pushed()
    many = loop.batch(0.02, runs=3, record="actual")
    assert np.array_equal(many["actual"][2], loop.run(0.02)["actual"])
    named = pushed(method="rodas").batch(0.02, runs=3, record="actual")
    assert np.array_equal(many["actual"], named["actual"])
    said = {"method": "rodas", "substeps": 1, "rtol": 1e-6, "atol": 1e-9}
    assert many.integration == named.integration == said and said.items() <= loop.run(0.02).manifest.items()


def test_the_manifest_of_a_continuous_loop_names_the_method_and_tolerances_that_ran():
    loop = Loop(reference=sine, controller=continuous_pi, plant=zoo.mass(gain=10.0), period=None, sample=0.01,
                rtol=1e-7, atol=1e-8, metrics={})  # fmt: skip
    said = loop.run(0.1, engine="python").manifest
    assert (said["method"], said["rtol"], said["atol"], said["substeps"]) == ("rodas", 1e-7, 1e-8, None)


def test_the_manifest_names_tolerances_only_where_they_count():
    parts = {"reference": sine, "controller": through, "metrics": {}}
    own = Loop(plant=resolve.block("xy_table"), substeps=4, **parts).integration
    assert own == {"method": "own step", "substeps": 4, "rtol": None, "atol": None}
    explicit = Loop(plant=zoo.mass, substeps=2, **parts).integration
    assert explicit == {"method": "rk4", "substeps": 2, "rtol": None, "atol": None}


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ({"method": "rk4"}, "method = 'rk4': with period=None the adaptive rodas integrates"),
        ({"substeps": 4}, "substeps = 4: with period=None rtol and atol set the steps"),
    ],
)
def test_what_a_continuous_loop_would_ignore_is_refused(option, words):
    with pytest.raises(ValueRefused, match=words):
        Loop(reference=sine, controller=continuous_pi, plant=zoo.mass, period=None, **option)


def test_only_a_plant_that_gives_its_derivative_can_be_declared_stiff():
    with pytest.raises(BlockError, match=r"steps: stiff=True .* a plant that takes dt brings its own step"):

        @plant(None, PIState(), stiff=True)
        def steps(s, u, dt):
            return PIState(s.integral + u * dt)

    with pytest.raises(BlockError, match=r"held: stiff=True .* this is a controller"):

        @controller(stiff=True)
        def held(command, feedback):
            return command


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "push"), [("backlash_two_mass", 200.0), ("ballscrew_axial", 12.0), ("mass_dahl", 5.0)]
)
def test_a_stiff_plant_at_0_75_ms_is_right_to_a_millionth_without_naming_a_method(name, push):
    parts = {"reference": sine(amplitude=push, frequency=2.0), "controller": through, "metrics": {}, "period": PERIOD}
    runs = [
        Loop(plant=resolve.block(name), **parts, **options).run(0.3, record="actual").check()
        for options in ({}, {"method": "rodas", "rtol": 1e-9, "atol": 1e-14})
    ]
    signal = next(k for k in runs[0].signals if k != "time")
    usual, tight = (run[signal] for run in runs)
    assert np.abs(usual - tight).max() < 1e-6 * np.ptp(tight)


def test_no_plant_of_the_catalogue_is_unstable_in_rk4_steps_of_1_ms_without_saying_that_it_is_stiff():
    """The fastest rate at rest and in motion, by differences: RK4 is stable on the real axis down to -2.785 / h."""
    blocks = [resolve.block(n) for n in catalogue.block_names()]
    found = {b.name: b for b in blocks if b.kind == "plant" and "dt" not in b.signals}
    assert {"ballscrew_stage", "mass_lugre", "backlash_two_mass"} <= set(found)
    assert {n: b.stiff for n, b in found.items()} == {n: 1e-3 * fastest_rate(b) > 2.785 for n, b in found.items()}


def fastest_rate(block):
    """The largest decay rate of a plant at rest and in motion, 1/s."""
    p = block.params if block.prepare is None else block.prepare(block.params, 1e-3)
    rest = block.initial(block.params) if block.initial is not None else block.state
    layout = Layout(as_floats(rest))

    def rates(x):
        s = layout.unpack(x, np.zeros(1))
        lead = [p] * (block.params is not None) + [s]
        return layout.pack(as_floats(block.step(*lead, *(0.0 for _ in block.signals))))[0]

    fastest = 0.0
    for speed in (0.0, 0.1):
        x = layout.pack(as_floats(rest))[0]
        x[[leaf.at for leaf in layout.scalars if "speed" in leaf.key]] = speed
        steps = 1e-9 * np.eye(len(x))
        jacobian = np.array([(rates(x + d) - rates(x - d)) / 2e-9 for d in steps]).T
        fastest = max(fastest, float(-np.linalg.eigvals(jacobian).real.min()))
    return fastest
