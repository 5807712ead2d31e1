"""The why of loops in motion: after changes, before the next period, and without disturbing a bit of the run."""

import json
import math
import warnings
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew import Loop, plant, resolve
from leadscrew.controllers._grey_fuzzy import tfc
from leadscrew.experiment import Experiment
from leadscrew.fuzzy import block
from leadscrew.operate.why import explainer
from leadscrew.references._step import step
from tests.fuzzy.systems import mamdani, sugeno
from tests.operate.plain import check_shares, said

SYSTEMS = {
    "mean": block.controller(sugeno(), {"e": ("error", 0.9), "de": ("change", 20.0)}, output_scale=30.0),
    "rate": block.controller(sugeno(), {"e": ("error", 0.5), "de": ("rate", 0.05)}, output_scale=0.1, incremental=True),
    "centroid": block.controller(mamdani(), {"e": ("error", 0.9), "de": ("change", 20.0)}, output_scale=30.0),
}


class Moving(NamedTuple):
    x: float = 0.0
    v: float = 0.0


@plant(None, Moving())
def cart(s, u):
    return Moving(s.v, u - 2.0 * s.v)


class Force(NamedTuple):
    force: float = 0.0


@plant(None, Force())
def cut(s, u):
    return Force(20.0 * (633.0 * u - s.force))


def loop_of(controller) -> Loop:
    return Loop(reference=step(target=0.8), controller=controller, plant=cart, period=0.01)


def last_row(run) -> dict[str, float]:
    return {k: float(v[-1]) for k, v in run.signals.items()}


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_fuzzy_systems_rules_are_those_of_the_period_that_comes(name: str) -> None:
    live = loop_of(SYSTEMS[name]).start(engine="python")
    why = explainer(live.loop, name)
    assert why.views == ("rules", "sets")
    run = live.advance(1)
    for _ in range(40):
        views = why.look(live, last_row(run))
        check_shares(views)
        given = views["rules"]["outputs"][0]["value"]
        run = live.advance(1, record=("command", "output", "controller"))
        assert given == run["controller.last"][0]
        assert views["rules"]["outputs"][-1]["value"] == run["output"][0]
        if name != "centroid":
            assert said(views) == pytest.approx(given, abs=1e-12)
    assert json.loads(json.dumps(views, allow_nan=False)) == views


def test_looking_changes_no_bit_of_the_run() -> None:
    looked, alone = (loop_of(SYSTEMS["rate"]).start(engine="python") for _ in range(2))
    why, rows = explainer(looked.loop, "x"), []
    for _ in range(15):
        run = looked.advance(3)
        rows.append(run["output"])
        why.look(looked, last_row(run))
    np.testing.assert_array_equal(np.concatenate(rows), alone.advance(45)["output"])


def test_a_loop_that_is_lost_in_the_period_that_comes_keeps_its_last_views() -> None:
    loop = Loop(
        reference=step(target=0.8), controller=SYSTEMS["mean"](scale_output=1e8), plant=cart, period=0.01, bound=1e3
    )
    live = loop.start(engine="python")
    why, seen, lost = explainer(loop, "wild"), {}, False
    for _ in range(60):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            row = last_row(live.advance(1)) if live.diverged is None else {}
        lost = lost or live.diverged is not None
        seen = why.look(live, row)
        assert set(seen) == {"rules", "sets"}
    assert lost


def test_a_parameter_changed_in_the_run_shows_at_once() -> None:
    loop = Loop(reference=step(target=150.0), controller=tfc(output_scale=0.001), plant=cut, period=0.02)
    live = loop.start(engine="python")
    why = explainer(loop, "tfc")
    row = last_row(live.advance(10))
    before = why.look(live, row)
    live.set("controller.error_scale", 8.4)
    live.set("controller.inference", 1)
    after = why.look(live, row)
    wide = [views["sets"]["inputs"][0]["high"] for views in (before, after)]
    assert wide == pytest.approx([6.0 * 4.2, 6.0 * 8.4])
    assert math.fsum(r["strength"] for r in before["rules"]["rules"]) == pytest.approx(1.0)
    for _ in range(20):
        was = live.values()["controller.output"]
        views = why.look(live, last_row(live.advance(1, record=("command", "output"))))
        assert live.values()["controller.output"] == pytest.approx(min(max(was + said(views), 0.0), 1.0), abs=1e-14)


def test_before_the_first_period_there_is_nothing_to_see_and_after_divergence_the_last() -> None:
    live = loop_of(SYSTEMS["mean"]).start(engine="python")
    why = explainer(live.loop, "mean")
    assert why.look(live, {}) == {}
    seen = why.look(live, last_row(live.advance(5)))
    live.diverged = live._divergence()
    assert why.look(live, {}) == seen
    assert set(why.look(live, {}, ("sets",))) == {"sets"}


CASES = (
    ("vud_lathe", "paper.vud", "fig11a_step_m50"),
    ("grey_turning", "ours.tfc_ff", "fig6_fixed_depth"),
    ("fsmc_ballscrew", "ours.fsmc_4khz", "sine_slow"),
    ("fsmc_ballscrew", "corrected.smc", "sine_slow"),
    ("sofnn_tangent", "ours.sofnn_tuned", "wave_fabric"),
)


@pytest.mark.slow
@pytest.mark.parametrize(("study", "controller", "scenario"), CASES)
def test_a_study_loop_is_explained_as_json(study: str, controller: str, scenario: str) -> None:
    loop = Experiment(study, controller, scenario).loop()
    live = loop.start()
    why = explainer(loop, controller)
    record = [c for c in live.program.plan.columns if c != "time"]
    for _ in range(40):
        row = last_row(live.advance(7, record=record))
        views = why.look(live, row)
        assert set(views) == set(why.views)
        json.dumps(views, allow_nan=False)
        for view in ("x", "y"):
            for name, _ in views.get("phase", {}).get(view, {}).get("terms", []):
                assert name in row


@pytest.mark.slow
def test_every_controller_of_every_study_is_explained_where_it_runs() -> None:
    """One loop of each family in motion, by the Python engine: the views have what their names promise."""
    seen = set()
    for study in ("vud_lathe", "grey_turning", "fsmc_ballscrew", "sofnn_tangent"):
        made = resolve.study(study)
        for name, controller in made.controllers.items():
            family = controller.step.__qualname__, controller.step.__module__
            why = explainer(loop := made.loop(name, next(iter(made.scenarios))), name)
            if not why.views or family in seen or loop.continuous:
                continue
            seen.add(family)
            live = loop.start(engine="python")
            record = [c for c in live.program.plan.columns if c != "time"]
            views = why.look(live, last_row(live.advance(4, record=record)))
            assert set(views) == set(why.views), name
            json.dumps(views, allow_nan=False)
    assert len(seen) >= 16
