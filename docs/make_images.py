"""Draws docs/images from the studies and the examples: run it again when a figure of the README or a guide has changed.

python docs/make_images.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from friction_images import images as friction_images_of_the_stage

from leadscrew import Loop, experiment, fuzzy, resolve
from leadscrew.bench import stage_picture
from leadscrew.controllers import axis_cascade
from leadscrew.experiment import Experiment
from leadscrew.identify.axis.fit import identify_axis
from leadscrew.logs import axis_log
from leadscrew.plants import servo_axis
from leadscrew.references import waypoints
from leadscrew.report import friction
from leadscrew.report import fuzzy as pictures
from leadscrew.report.identified_axis import friction_figure, position_figure
from leadscrew.report.tuned import figures, units
from leadscrew.sensors import axis_reading
from leadscrew.studies.lab import Lab
from leadscrew.tune.job import Job
from leadscrew.tune.tuner import tune

IMAGES = {
    "lathe": ("vud_lathe", "fig11b_position_m170"),
    **{name: ("sofnn_tangent", name) for name in ("pieces_error", "pieces_swap", "pieces_recall")},
}
"""Name of the image; study and picture that it is."""
EXAMPLES = Path(__file__).parents[1] / "examples"


def fuzzy_images(folder: Path) -> None:
    """The fuzzy system of the guide: its sets, its surface, its rules along the run of the example."""
    system = fuzzy.read(EXAMPLES / "axis.fll")
    found = experiment.read(EXAMPLES / "axis_on_the_lathe.toml")
    loop = found.loop()
    run = loop.run(found.seconds())
    p = loop.blocks["controller"].params
    error = run["error"]
    points = np.column_stack([p.scale_e * error, p.scale_de * np.diff(error, prepend=error[0])])
    for name, figure in (
        ("sets", pictures.membership_figure(system)),
        ("surface", pictures.surface_figure(system)),
        ("activity", pictures.activity_figure(system, run.time, points)),
    ):
        figure.savefig(folder / f"fuzzy_{name}.png", dpi=110)


def tuning_images(folder: Path) -> None:
    """The two tunings of the guide: held-out plants before and after, and the Pareto front."""
    lathe = Job(Experiment("vud_lathe", "corrected.vud_beta_e"), ("fig11a_step_m50", "fig11b_step_m170"))
    vary = {"controller.output_gain": "0.5:4:log", "controller.output_tau": (0.2, 1.2), "controller.tau": (0.3, 1.5)}
    over = {"plant.full_duty_speed_mm_s": (259.0, 334.0)}
    one = tune(lathe, vary, ["settling_2um"], ["overshoot<=0.005"], over=over, seed=1)
    figures(one, units(lathe))["held_out"].savefig(folder / "tune_held_out.png", dpi=100)
    goals, kept = ["settling_2um", "p95:overshoot"], ["error_after_2s@fig11a_step_m50<=0.001"]
    several = tune(lathe, vary, goals, kept, over=over, plants=6, held_out=20, budget=100, seed=1)
    figures(several, units(lathe))["front"].savefig(folder / "tune_front.png", dpi=100)


def friction_images(folder: Path) -> None:
    """The pictures of the page on friction and backlash."""
    for name, draw in (
        ("friction_velocity", friction.friction_velocity_figure),
        ("friction_presliding", friction.presliding_figure),
        ("friction_break_away", friction.break_away_figure),
        ("friction_stick_slip", friction.stick_slip_figure),
        ("backlash_classic", friction.classic_figure),
        ("backlash_modern", friction.modern_figure),
    ):
        draw().savefig(folder / f"{name}.png", dpi=90)


def integration_image(folder: Path) -> None:
    """Error against speed of the integrators, on this machine."""
    stage_picture.figure().savefig(folder / "stiff_friction.png", dpi=90)


def friction_of_the_stage_images(folder: Path) -> None:
    """The pictures of the pages on a controller that learns its friction, and on friction from one log."""
    for name, figure in friction_images_of_the_stage().items():
        figure.savefig(folder / f"{name}.png", dpi=90)


def identification_images(folder: Path) -> None:
    """The pictures of the page on an axis from its log: friction that rises towards rest, fitted without that."""
    friction = {"coulomb": 20.0, "static": 35.0, "stribeck_speed": 0.02, "viscous": 150.0}
    stage = servo_axis(
        mass=60.0, force_per_drive=20.0, offset=0.0,
        **{f"friction.{way}.{name}": value for way in ("forward", "backward") for name, value in friction.items()},
    )  # fmt: skip
    places = [0, 200, 20, 120, 80, 100, 90, 95, 94, 96, 60, 61, 20, 180, 100, 101, 90, 40, 42, 0, 150, 50, 53, 0]
    loop = Loop(
        reference=waypoints(places, dwell=0.15, max_velocity=150.0, max_acceleration=1500.0, max_jerk=5e4),
        controller=axis_cascade(kpos=40.0, kvp=0.4, kvi=0.0, lower=-10.0, upper=10.0), plant=stage,
        sensor=axis_reading(resolution=1e-4, noise=1e-4), period=1e-3, seed=3, metrics={},
    )  # fmt: skip
    run = loop.run(16.0, record=("output", "feedback"))
    log = axis_log(run.time, run["output"], run["feedback"], position_unit="mm", drive_unit="V", force_per_drive=20.0)
    fit = identify_axis(log, model="coulomb", symmetric=True, refine="none")
    for name, draw in (("position", position_figure), ("friction", friction_figure)):
        draw(fit).savefig(folder / f"identify_axis_{name}.png", dpi=90)


def main(folder: Path = Path(__file__).parent / "images") -> None:
    """Draws every image."""
    folder.mkdir(exist_ok=True)
    labs = {study: Lab(resolve.study(study)) for study, _ in IMAGES.values()}
    for image, (study, wanted) in IMAGES.items():
        assert labs[study].study.contents is not None
        shown = next(f for f in labs[study].study.contents().figures if f.name == wanted)
        shown.draw(labs[study]).savefig(folder / f"{image}.png", dpi=110)
    fuzzy_images(folder)
    tuning_images(folder)
    friction_images(folder)
    integration_image(folder)
    friction_of_the_stage_images(folder)
    identification_images(folder)


if __name__ == "__main__":
    main()
