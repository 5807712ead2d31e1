"""The table of exports: every controller, and the loop that is recorded. A new controller joins by a row."""

from functools import lru_cache
from typing import NamedTuple

from leadscrew.experiment import Experiment
from leadscrew.export.controller import export_controller
from leadscrew.export.folder import TARGETS, compiler_path, write
from leadscrew.export.verdict import NOT_RUN
from tests.tools import missing

LOOPS, EXAMPLES = "tests/export/loops.py:", "examples/"


class Row(NamedTuple):
    """What to export, and how long its loop is recorded; ``quick`` says to which targets `make test` does it."""

    subject: str
    controller: str | None
    seconds: float
    quick: tuple[str, ...] = ("c99",)
    real: str = "double"
    backwards: bool = True
    """Whether a negative command moves it backwards; a feed that holds a force never goes back."""


ROWS = {
    "vud_beta_e": Row("vud_lathe", "corrected.vud_beta_e", 1.0, tuple(TARGETS)),
    "vud": Row("vud_lathe", "paper.vud", 1.0, ()),
    "vud_family": Row("vud_lathe", "corrected.vud_beta_max", 1.0, ()),
    "vud_incremental": Row("vud_lathe", "ours.vud_incremental", 1.0, ()),
    "vud_integral_factor": Row("vud_lathe", "ours.vud_integral_factor", 1.0, ()),
    "vud_scaled": Row("vud_lathe", "ours.vud_opt", 1.0),
    "vud_scaled, against friction": Row(f"{LOOPS}lathe_with_a_dead_zone", None, 1.0, ()),
    "duty_pd": Row("vud_lathe", "ours.pd", 1.0),
    "duty_pd_observed": Row("vud_lathe", "ours.pd_observed_robust", 1.0, ()),
    "duty_pid": Row("tests/controllers/lathe_loop.py:pid", None, 1.0, ()),
    "vud_fast": Row("tests/controllers/lathe_loop.py:fast", None, 1.0),
    "power_law": Row("vud_lathe", "ours.original_fit", 1.0),
    "npid": Row(f"{EXAMPLES}xy_table_npid.py:loop", None, 0.5, ("c99", "hal")),
    "npid_after": Row(f"{LOOPS}npid_with_the_gain_behind", None, 0.3, ()),
    "npid_slope": Row(f"{LOOPS}npid_of_limited_slope", None, 0.3, ()),
    "npid_split": Row(f"{LOOPS}npid_in_two_paths", None, 0.3, ()),
    "pid": Row(f"{LOOPS}pid", None, 0.5),
    "pid, biquad": Row(f"{LOOPS}pid_through_a_notch", None, 0.3, ()),
    "low_pass": Row(f"{LOOPS}low_passed", None, 0.3, ()),
    "notch": Row(f"{LOOPS}notched", None, 0.3, ()),
    "lead_lag": Row(f"{LOOPS}leading", None, 0.3, ()),
    "pid, low_pass, lead_lag, series": Row(f"{LOOPS}pid_behind_filters", None, 0.3),
    "pid, dead_zone_inverse": Row(f"{LOOPS}pid_against_a_dead_zone", None, 0.3, ()),
    "pid, tracking_differentiator": Row(f"{LOOPS}pid_with_a_tracking_differentiator", None, 0.3, ()),
    "pid, learned_feed_forward": Row(f"{LOOPS}table_that_learns_its_friction", None, 0.3, ()),
    "axis_cascade": Row(f"{LOOPS}identified_axis", None, 0.5, ()),
    "cascade_ppi": Row(f"{LOOPS}cascade", None, 0.5, ()),
    "pid, input_dob": Row(f"{LOOPS}input_observer", None, 0.5, ()),
    "pid, friction_feed_forward": Row(f"{LOOPS}friction_fed_forward", None, 0.5, ()),
    "pid, adaptive_resonant": Row(f"{LOOPS}following_the_spindle", None, 0.5, ()),
    "pid, repetitive": Row(f"{LOOPS}repeating", None, 1.5, ()),
    "pid, resonant": Row(f"{LOOPS}resonant_table", None, 0.5, ()),
    "pid, resonant, inverse_feed_forward": Row(f"{LOOPS}resonant_table_fed_forward", None, 0.5, ()),
    "smc": Row(f"{EXAMPLES}ballscrew_smc.py:loop", None, 0.3, ("c99", "fmu2")),
    "csmc": Row(f"{EXAMPLES}ballscrew_smc.py:complementary", None, 0.3, ()),
    "smc_integral": Row(f"{LOOPS}sliding_with_integral", None, 0.3, ()),
    "fsmc": Row(f"{LOOPS}sliding_with_fuzzy_rules", None, 0.3),
    "fsmc_printed": Row(f"{LOOPS}sliding_with_the_printed_rules", None, 0.3, ()),
    "pd_dob": Row(f"{LOOPS}disturbance_observer", None, 0.3),
    "pd_learned": Row("tests/controllers/learned_stage.py:learned", None, 0.3, ()),
    "pd_dob, feed_forward_table": Row("tests/controllers/table_loop.py:taught", None, 0.3, ()),
    "super_twisting": Row(f"{LOOPS}super_twisted", None, 0.3),
    "torque_pid": Row("tests/controllers/drive_loop.py:pid", None, 0.3, ()),
    "tfc, force_guard": Row(f"{LOOPS}force_under_guard", None, 6.0, (), backwards=False),
    "tfc, feed_override, under guard": Row(f"{EXAMPLES}turning_guard.py:loop", None, 6.0, (), backwards=False),
    "tfc, feed_override, under guard at 1 ms": Row(f"{EXAMPLES}turning_guard.py:fast", None, 4.0, (), backwards=False),
    "tfc": Row("tests/controllers/grey_fuzzy_loop.py:traditional", None, 6.0, backwards=False),
    "gpfc": Row("tests/controllers/grey_fuzzy_loop.py:grey", None, 6.0, ("c99",), backwards=False),
    "gpfc, reading A": Row("tests/controllers/grey_fuzzy_loop.py:grey_smallest", None, 6.0, (), backwards=False),
    "smith": Row("tests/controllers/grey_fuzzy_loop.py:with_a_model", None, 6.0, (), backwards=False),
    "tfc, depth_feed_forward": Row("tests/controllers/force_loop.py:fed_forward", None, 6.0, (), backwards=False),
    "gpfc, gain_normalised, depth_feed_forward": Row(
        "tests/controllers/force_loop.py:grey_normalised_fed_forward", None, 6.0, (), backwards=False
    ),
    "tfc, gain_normalised": Row("tests/controllers/force_loop.py:normalised", None, 6.0, (), backwards=False),
    "power_law_inversion": Row("tests/controllers/force_loop.py:inverted", None, 6.0, (), backwards=False),
    "constant_force": Row("tests/controllers/force_loop.py:all_in_one", None, 6.0, ("hal",), backwards=False),
    "pi_incremental": Row("tests/controllers/grey_fuzzy_loop.py:proportional", None, 6.0, (), backwards=False),
    "tangent_dob": Row("tests/controllers/tangent_loop.py:observed", None, 4.0, ("c99",)),
    "tangent_dob, taught_offset": Row("tests/controllers/tangent_loop.py:taught", None, 3.0, ()),
    "curvature_feed_forward": Row("tests/controllers/tangent_loop.py:fed_forward", None, 3.0, (), backwards=False),
    "curvature_network": Row("tests/controllers/tangent_loop.py:by_rules", None, 4.0, (), backwards=False),
    "taught_alone": Row("tests/controllers/tangent_loop.py:by_table", None, 4.0, (), backwards=False),
    "sofnn": Row("tests/controllers/sofnn_loop.py:network_that_learns", None, 5.0, (), backwards=False),
    "sofnn, of the paper": Row("tests/controllers/sofnn_loop.py:network_of_the_paper", None, 5.0, (), backwards=False),
    "sofnn_all_weights": Row("tests/neural/groups_loop.py:all_groups", None, 3.0, (), backwards=False),
    "sofnn, by LMS": Row("tests/controllers/sofnn_loop.py:network_by_lms", None, 5.0, (), backwards=False),
    "sofc": Row("tests/controllers/sofnn_loop.py:rules_that_learn", None, 5.0, (), backwards=False),
    "fnn": Row("tests/controllers/sofnn_loop.py:fixed_network", None, 5.0, (), backwards=False),
    "fuzzy, exact": Row(f"{LOOPS}fuzzy_exact", None, 0.4),
    "fuzzy, sampled": Row(f"{LOOPS}fuzzy_sampled", None, 0.4, ()),
    "fuzzy, table": Row(f"{LOOPS}fuzzy_table", None, 0.4),
    "fuzzy, single precision": Row(f"{LOOPS}fuzzy_sampled", None, 0.4, (), "float"),
    "single precision": Row("vud_lathe", "corrected.vud_beta_e", 1.0, ("c99",), "float"),
    "60 s, step": Row("vud_lathe", "corrected.vud_beta_e", 60.0, ()),
    "60 s, to and fro": Row(f"{LOOPS}lathe_to_and_fro", None, 60.0, ()),
}

TOOLS = {"c99 gcc": "gcc", "hal": "linuxcnc", "fmu2 FMPy": "fmpy", "fmu3 FMPy": "fmpy", "ecos": "ecospy"}
"""What LEADSCREW_REQUIRE calls the tools behind a verdict; clang is never required."""


@lru_cache
def loop_of(row):
    """The loop of a row."""
    subject, controller = ROWS[row][:2]
    return Experiment(subject, controller).with_first_scenario().loop()


@lru_cache
def exported(row):
    """What the exporter makes of a row, whatever the target."""
    return export_controller(loop_of(row), ROWS[row].seconds, name="ours", title=row, real=ROWS[row].real)


def folder_of(row, target, tmp_path):
    """The row as an exported folder."""
    if compiler_path() is None:
        missing("gcc", "there is no C compiler on this machine")
    core, record = exported(row)
    write(core, record, target, tmp_path / "out", loop=loop_of(row))
    return tmp_path / "out"


def needs_no_tool(verdict):
    """Whether a verdict may be missing on a machine that has everything."""
    return "clang" in verdict.target or "single precision" in verdict.note


def complete(found):
    """Skips, or fails where it is required, if a tool was missing for one of the verdicts."""
    for verdict in found:
        if verdict.verdict == NOT_RUN and not needs_no_tool(verdict):
            missing(next(tool for what, tool in TOOLS.items() if what in verdict.target), verdict.note)
