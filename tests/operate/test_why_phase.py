"""The phase plane of sliding-mode controllers: the line, the layer and the point are those of the law."""

import math

import numpy as np
import pytest

from leadscrew.controllers._friction_feed_forward import friction_feed_forward
from leadscrew.controllers._look_ahead import look_ahead
from leadscrew.controllers._sliding.complementary import csmc
from leadscrew.controllers._sliding.continuous import Seen, csmc_ideal, fsmc_ideal, smc_ideal, smc_integral_ideal
from leadscrew.controllers._sliding.conventional import smc
from leadscrew.controllers._sliding.fuzzy import fsmc
from leadscrew.controllers._sliding.integral import smc_integral
from leadscrew.controllers._sliding.super_twisting import super_twisting
from leadscrew.friction.lugre import steady_friction
from leadscrew.fuzzy.views import Now
from leadscrew.kernel.by_position import prepared
from leadscrew.operate.why import explained
from leadscrew.references._motion import Motion
from leadscrew.studies.fsmc_ballscrew.tunings import FUZZY as TUNINGS
from tests.operate.plain import check_shares, periods, row_of

RNG = np.random.default_rng(4)
OFF = 1e-5 * np.cumsum(RNG.normal(size=300))


def trail(axis, signals):
    """The coordinate of a phase plane's trail: the sum of an axis's terms over recorded signals."""
    return sum(factor * signals[name] for name, factor in axis["terms"])


def moving(k: int) -> tuple[Motion, float]:
    """A stage on a sine of 0.2 rad at 0.5 Hz, off by up to a few hundred microradians."""
    w, t = math.pi, k / 4000.0
    command = Motion(0.2 * math.sin(w * t), 0.2 * w * math.cos(w * t), -0.2 * w * w * math.sin(w * t))
    return command, command.position + OFF[k]


def in_mm(k: int) -> tuple[Motion, float]:
    command, feedback = moving(k)
    return Motion(*(1.5923 * x for x in command)), 1.5923 * feedback


def gain(p, speed: float) -> float:
    """K by its formula."""
    return steady_friction(p.bound, speed) / p.inertia + p.eta


@pytest.mark.parametrize("block", [smc, csmc, smc_integral, super_twisting, fsmc], ids=lambda b: b.name)
def test_the_point_is_the_error_and_its_rate_of_the_law(block) -> None:
    last = None
    for at in periods(block(travel_per_rad=1.5923), in_mm, 1.0 / 4000.0, 60):
        plane, e = at.views["phase"], at.feedback / 1.5923 - at.command.position / 1.5923
        assert plane["x"]["value"] == pytest.approx(e, abs=1e-15)
        if last is not None:
            difference = (at.feedback - last.feedback) / 1.5923 * 4000.0
            rate = difference - at.command.velocity / 1.5923
            if block.name != "super_twisting":  # which has a filter
                assert plane["y"]["value"] == pytest.approx(rate, abs=1e-9)
            assert plane["x"]["low"] <= e <= plane["x"]["high"]
        last = at


@pytest.mark.parametrize("rate", [0.0, 4000.0])
def test_the_layer_is_where_the_switching_torque_is_not_at_its_limit(rate: float) -> None:
    block = smc(layer_rate=rate, boundary=0.1, eta=1.0)
    inside = 0
    for at in periods(block, moving, 1.0 / 4000.0, 300):
        p, plane = block.params, at.views["phase"]
        wanted = (at.output - at.after.friction) / p.inertia
        switching = at.command.acceleration - p.lam * plane["y"]["value"] - wanted
        most = gain(p, at.after.speed)
        assert plane["inside"] == (abs(switching) < most * (1.0 - 1e-9))
        assert plane["phi"] == pytest.approx(most / rate if rate else 0.1)
        assert plane["s"] == pytest.approx(at.after.surface, abs=1e-12)
        inside += plane["inside"]
    assert inside > 0
    assert rate or inside < 300


def line_through(points) -> tuple[float, float]:
    (x0, y0), (x1, y1) = points
    slope = (y1 - y0) / (x1 - x0)
    return slope, y0 - slope * x0


def test_the_lines_are_those_of_the_printed_equations() -> None:
    for block, slope, share in ((smc, -150.0, 1.0), (csmc, -150.0, 0.5), (super_twisting, -600.0, 1.0)):
        for at in periods(block, moving, 1.0 / 4000.0, 30):
            plane = at.views["phase"]
            assert line_through(plane["surface"]) == pytest.approx((slope, 0.0), abs=1e-12)
            above, below = (line_through(x) for x in plane["layer"])
            assert above == pytest.approx((slope, share * plane["phi"]))
            assert below == pytest.approx((slope, -share * plane["phi"]))
    # With an integral the line moves: e' = -2 lambda e - lambda^2 xi.
    moved = []
    for at in periods(smc_integral, moving, 1.0 / 4000.0, 100):
        slope, height = line_through(at.views["phase"]["surface"])
        assert slope == pytest.approx(-300.0)
        assert height == pytest.approx(-(150.0**2) * at.after.xi, abs=1e-12)
        moved.append(height)
    assert np.ptp(moved) > 1e-3


@pytest.mark.parametrize("name", [n for n in TUNINGS if n.endswith("khz")])
def test_the_rules_of_fuzzy_sliding_mode_are_those_that_made_its_torque(name: str) -> None:
    block = TUNINGS[name]
    for at in periods(block, moving, 1.0 / 4000.0, 60):
        check_shares(at.views)
        p, rules, plane = block.params, at.views["rules"], at.views["phase"]
        outputs = {o["name"]: o["value"] for o in rules["outputs"]}
        assert outputs["k"] == pytest.approx(at.after.k, abs=1e-14)
        wanted = (at.output - at.after.friction - outputs["torque"]) / p.inertia
        e, rate, xi = plane["x"]["value"], plane["y"]["value"], at.after.xi
        equivalent = at.command.acceleration - p.lam * (3.0 * rate + p.lam * (3.0 * e + p.lam * xi))
        assert wanted == pytest.approx(equivalent, abs=1e-6)
        assert plane["s"] == pytest.approx(p.scale_s * at.after.s, abs=1e-12)
        assert rules["inputs"][0]["value"] == pytest.approx(plane["s"], abs=1e-12)


def test_changed_numbers_of_the_fuzzy_system_are_the_ones_that_are_shown() -> None:
    tables = fsmc.params.tables
    terms = tables.terms.copy()
    # The peak of Z, and the feet of its neighbours, from 0 to 0.2.
    terms[0, 2] = terms[1, 1] = terms[2, 0] = 0.2
    block = fsmc(**{"tables.terms": terms})
    for at in periods(block, moving, 1.0 / 4000.0, 30):
        outputs = {o["name"]: o["value"] for o in at.views["rules"]["outputs"]}
        assert outputs["k"] == pytest.approx(at.after.k, abs=1e-14)
        middle = at.views["sets"]["inputs"][0]["sets"][1]
        assert [0.2 * block.params.scale_s, 1.0] in middle["points"]


@pytest.mark.parametrize("block", [smc_ideal, csmc_ideal, smc_integral_ideal, fsmc_ideal], ids=lambda b: b.name)
def test_without_sampling_the_point_comes_from_the_signals(block) -> None:
    block = block(friction_from=0)
    p, per = block.params, 1.0 / block.params.travel_per_rad
    found = explained(block)
    assert found is not None
    for command, e, rate, xi in ((Motion(1.0, 2.0, 3.0), 1e-4, -2e-3, 1e-7), (Motion(0.0, 0.0, 0.0), -3e-4, 0.01, 0.0)):
        feedback = Seen(command.position + e / per, command.velocity + rate / per)
        state = block.state._replace(xi=xi)
        _, torque = block.step(prepared(block, 1.0), state, command, feedback)
        row = row_of(command=command, feedback=feedback) | {"controller.xi": xi}
        views = found[1].look(Now(p, state, row, 1.0))
        plane = views["phase"]
        assert (plane["x"]["value"], plane["y"]["value"]) == pytest.approx((e, rate), rel=1e-9)
        assert (trail(plane["x"], row), trail(plane["y"], row)) == pytest.approx((e, rate), rel=1e-9)
        damped = p.lam * rate
        if block.name != "smc_ideal":
            damped = p.lam * (3.0 * rate + p.lam * (3.0 * e + p.lam * xi))
        if "rules" in views:
            push = next(o["value"] for o in views["rules"]["outputs"] if o["name"] == "torque") / p.inertia
        else:
            most = gain(p, rate + command.velocity * per)
            push = -most * min(1.0, max(-1.0, plane["s"] / plane["phi"]))
        assert torque == pytest.approx(p.inertia * (command.acceleration * per - damped + push), rel=1e-9)


def test_the_trail_is_drawn_of_recorded_columns() -> None:
    for block in (smc, friction_feed_forward(smc)):
        part, _ = explained(block)
        for at in periods(block, moving, 1.0 / 4000.0, 20):
            row = row_of(command=at.command, feedback=at.feedback)
            row |= {f"{part.column}angle": at.after.angle, f"{part.column}speed": at.after.speed}
            plane = at.views["phase"]
            assert trail(plane["x"], row) == pytest.approx(plane["x"]["value"])
            assert trail(plane["y"], row) == pytest.approx(plane["y"]["value"])
    assert part.column == "controller.inner."


def test_a_controller_that_looks_ahead_shows_no_plane() -> None:
    """Its law sees another command than the signals have, so that the point would not be its."""
    assert explained(look_ahead(smc)) is None
