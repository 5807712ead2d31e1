"""Every block and study by name: plain tables, and what installed packages add.

Adding a block is one file, its name in the ``__init__.pyi`` of its package, and one row here. An installed package
joins through the entry points ``leadscrew.blocks`` and ``leadscrew.studies``. Names of files: :mod:`leadscrew.resolve`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import BlockError, LeadscrewError, NameUnknown

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from leadscrew.kernel.block import Block

BLOCKS: dict[str, str] = {
    # references
    "chirp": "leadscrew.references:chirp",
    "cut_line": "leadscrew.references:cut_line",
    "cutting_force": "leadscrew.references:cutting_force",
    "cutting_program": "leadscrew.references:cutting_program",
    "eased_sine": "leadscrew.references:eased_sine",
    "eased_sine_motion": "leadscrew.references:eased_sine_motion",
    "filtered_step": "leadscrew.references:filtered_step",
    "lathe_program": "leadscrew.references:lathe_program",
    "log_chirp": "leadscrew.references:log_chirp",
    "quintic": "leadscrew.references:quintic",
    "ramp": "leadscrew.references:ramp",
    "ramp_motion": "leadscrew.references:ramp_motion",
    "s_curve": "leadscrew.references:s_curve",
    "sine": "leadscrew.references:sine",
    "sine_motion": "leadscrew.references:sine_motion",
    "step": "leadscrew.references:step",
    "trapezoid": "leadscrew.references:trapezoid",
    # sensors
    "axis_encoder": "leadscrew.sensors:axis_encoder",
    "axis_reading": "leadscrew.sensors:axis_reading",
    "cut_camera": "leadscrew.sensors:cut_camera",
    "cut_reading": "leadscrew.sensors:cut_reading",
    "dual_encoder": "leadscrew.sensors:dual_encoder",
    "encoder_count": "leadscrew.sensors:encoder_count",
    "faulty_load_cell": "leadscrew.sensors:faulty_load_cell",
    "filtered_ruler": "leadscrew.sensors:filtered_ruler",
    "grating_count": "leadscrew.sensors:grating_count",
    "grating_counter": "leadscrew.sensors:grating_counter",
    "grating_ruler": "leadscrew.sensors:grating_ruler",
    "ideal": "leadscrew.sensors:ideal",
    "lag": "leadscrew.sensors:lag",
    "lathe_reading": "leadscrew.sensors:lathe_reading",
    "lathe_sensors": "leadscrew.sensors:lathe_sensors",
    "load_cell": "leadscrew.sensors:load_cell",
    "noisy": "leadscrew.sensors:noisy",
    "noisy_encoder": "leadscrew.sensors:noisy_encoder",
    "noisy_grating": "leadscrew.sensors:noisy_grating",
    "noisy_position": "leadscrew.sensors:noisy_position",
    "noisy_ruler": "leadscrew.sensors:noisy_ruler",
    "ruler": "leadscrew.sensors:ruler",
    "screw_encoder": "leadscrew.sensors:screw_encoder",
    # controllers
    "axis_cascade": "leadscrew.controllers:axis_cascade",
    "cascade_ppi": "leadscrew.controllers:cascade_ppi",
    "constant_force": "leadscrew.controllers:constant_force",
    "csmc": "leadscrew.controllers:csmc",
    "csmc_ideal": "leadscrew.controllers:csmc_ideal",
    "curvature_feed_forward": "leadscrew.controllers:curvature_feed_forward",
    "curvature_network": "leadscrew.controllers:curvature_network",
    "duty_pd": "leadscrew.controllers:duty_pd",
    "duty_pd_observed": "leadscrew.controllers:duty_pd_observed",
    "duty_pid": "leadscrew.controllers:duty_pid",
    "fnn": "leadscrew.controllers:fnn",
    "fsmc": "leadscrew.controllers:fsmc",
    "fsmc_ideal": "leadscrew.controllers:fsmc_ideal",
    "fsmc_printed": "leadscrew.controllers:fsmc_printed",
    "fsmc_printed_ideal": "leadscrew.controllers:fsmc_printed_ideal",
    "gpfc": "leadscrew.controllers:gpfc",
    "lead_lag": "leadscrew.controllers:lead_lag",
    "low_pass": "leadscrew.controllers:low_pass",
    "notch": "leadscrew.controllers:notch",
    "npid": "leadscrew.controllers:npid",
    "npid_after": "leadscrew.controllers:npid_after",
    "npid_slope": "leadscrew.controllers:npid_slope",
    "npid_split": "leadscrew.controllers:npid_split",
    "pd_dob": "leadscrew.controllers:pd_dob",
    "pd_learned": "leadscrew.controllers:pd_learned",
    "pid": "leadscrew.controllers:pid",
    "pi_incremental": "leadscrew.controllers:pi_incremental",
    "power_law": "leadscrew.controllers:power_law",
    "power_law_inversion": "leadscrew.controllers:power_law_inversion",
    "smc": "leadscrew.controllers:smc",
    "smc_ideal": "leadscrew.controllers:smc_ideal",
    "smc_integral": "leadscrew.controllers:smc_integral",
    "smc_integral_ideal": "leadscrew.controllers:smc_integral_ideal",
    "smith": "leadscrew.controllers:smith",
    "sofc": "leadscrew.controllers:sofc",
    "sofnn": "leadscrew.controllers:sofnn",
    "sofnn_all_weights": "leadscrew.controllers:sofnn_all_weights",
    "super_twisting": "leadscrew.controllers:super_twisting",
    "tangent_dob": "leadscrew.controllers:tangent_dob",
    "tfc": "leadscrew.controllers:tfc",
    "torque_pid": "leadscrew.controllers:torque_pid",
    "vud": "leadscrew.controllers:vud",
    "vud_beta_e": "leadscrew.controllers:vud_beta_e",
    "vud_family": "leadscrew.controllers:vud_family",
    "vud_fast": "leadscrew.controllers:vud_fast",
    "vud_incremental": "leadscrew.controllers:vud_incremental",
    "vud_integral_factor": "leadscrew.controllers:vud_integral_factor",
    "vud_scaled": "leadscrew.controllers:vud_scaled",
    # actuators
    "dac": "leadscrew.actuators:dac",
    "dead_zone": "leadscrew.actuators:dead_zone",
    "lathe_dac": "leadscrew.actuators:lathe_dac",
    "limits": "leadscrew.actuators:limits",
    "offset": "leadscrew.actuators:offset",
    "pwm": "leadscrew.actuators:pwm",
    "saturation": "leadscrew.actuators:saturation",
    "stiction": "leadscrew.actuators:stiction",
    "torque_drive": "leadscrew.actuators:torque_drive",
    # plants
    "backlash_axis": "leadscrew.plants:backlash_axis",
    "backlash_two_mass": "leadscrew.plants:backlash_two_mass",
    "ballscrew_axial": "leadscrew.plants:ballscrew_axial",
    "ballscrew_backlash": "leadscrew.plants:ballscrew_backlash",
    "ballscrew_gms": "leadscrew.plants:ballscrew_gms",
    "ballscrew_play": "leadscrew.plants:ballscrew_play",
    "ballscrew_stage": "leadscrew.plants:ballscrew_stage",
    "ballscrew_stage_fixed": "leadscrew.plants:ballscrew_stage_fixed",
    "flexible_cut": "leadscrew.plants:flexible_cut",
    "lathe_screw": "leadscrew.plants:lathe_screw",
    "lathe_servo": "leadscrew.plants:lathe_servo",
    "lathe_servo_limited": "leadscrew.plants:lathe_servo_limited",
    "mass_dahl": "leadscrew.plants:mass_dahl",
    "mass_lugre": "leadscrew.plants:mass_lugre",
    "mass_maxwell_slip": "leadscrew.plants:mass_maxwell_slip",
    "mass_stribeck": "leadscrew.plants:mass_stribeck",
    "servo_axis": "leadscrew.plants:servo_axis",
    "servo_axis_lugre": "leadscrew.plants:servo_axis_lugre",
    "turning": "leadscrew.plants:turning",
    "turning_lathe": "leadscrew.plants:turning_lathe",
    "xy_table": "leadscrew.plants:xy_table",
    "xy_table_lugre": "leadscrew.plants:xy_table_lugre",
    "xy_table_two_mass": "leadscrew.plants:xy_table_two_mass",
    "xy_table_cutting": "leadscrew.plants:xy_table_cutting",
    # disturbances
    "cut_load": "leadscrew.disturbances:cut_load",
    "five_sines": "leadscrew.disturbances:five_sines",
    "five_sines_pulse": "leadscrew.disturbances:five_sines_pulse",
    "hard_spot": "leadscrew.disturbances:hard_spot",
    "kicked_load": "leadscrew.disturbances:kicked_load",
    "pulse_load": "leadscrew.disturbances:pulse_load",
    "sine_load": "leadscrew.disturbances:sine_load",
    "step_load": "leadscrew.disturbances:step_load",
    "wandering_spindle": "leadscrew.disturbances:wandering_spindle",
    "white_noise": "leadscrew.disturbances:white_noise",
    # metrics
    "metrics.chatter": "leadscrew.kernel.metrics:chatter",
    "metrics.effort": "leadscrew.kernel.metrics:effort",
    "metrics.iae": "leadscrew.kernel.metrics:iae",
    "metrics.ise": "leadscrew.kernel.metrics:ise",
    "metrics.itae": "leadscrew.kernel.metrics:itae",
    "metrics.max_error": "leadscrew.kernel.metrics:max_error",
    "metrics.overshoot": "leadscrew.kernel.metrics:overshoot",
    "metrics.rise_time": "leadscrew.kernel.metrics:rise_time",
    "metrics.rms_error": "leadscrew.kernel.metrics:rms_error",
    "metrics.settling_time": "leadscrew.kernel.metrics:settling_time",
    "metrics.steady_state_error": "leadscrew.kernel.metrics:steady_state_error",
    "metrics.zero_crossing_rate": "leadscrew.kernel.metrics:zero_crossing_rate",
}
"""Blocks that are ready to use."""

FACTORIES: dict[str, str] = {
    "adaptive_resonant": "leadscrew.controllers:adaptive_resonant",
    "biquad": "leadscrew.controllers:biquad",
    "dead_zone_inverse": "leadscrew.controllers:dead_zone_inverse",
    "depth_feed_forward": "leadscrew.controllers:depth_feed_forward",
    "feed_forward_table": "leadscrew.controllers:feed_forward_table",
    "feed_override": "leadscrew.controllers:feed_override",
    "force_guard": "leadscrew.controllers:force_guard",
    "friction_feed_forward": "leadscrew.controllers:friction_feed_forward",
    "friction_test": "leadscrew.references:friction_test",
    "fuzzy.controller": "leadscrew.fuzzy:controller",
    "gain_normalised": "leadscrew.controllers:gain_normalised",
    "input_dob": "leadscrew.controllers:input_dob",
    "inverse_feed_forward": "leadscrew.controllers:inverse_feed_forward",
    "lathe_loops": "leadscrew.controllers:lathe_loops",
    "learned_feed_forward": "leadscrew.controllers:learned_feed_forward",
    "look_ahead": "leadscrew.controllers:look_ahead",
    "logged_command": "leadscrew.references:logged_command",
    "path": "leadscrew.references:path",
    "path_from_gcode": "leadscrew.references:path_from_gcode",
    "repetitive": "leadscrew.controllers:repetitive",
    "resonant": "leadscrew.controllers:resonant",
    "series": "leadscrew.controllers:series",
    "stairs": "leadscrew.references:stairs",
    "state_space": "leadscrew.plants:state_space",
    "taught_alone": "leadscrew.controllers:taught_alone",
    "taught_offset": "leadscrew.controllers:taught_offset",
    "tracking_differentiator": "leadscrew.controllers:tracking_differentiator",
    "transfer_function": "leadscrew.plants:transfer_function",
    "waypoints": "leadscrew.references:waypoints",
}
"""Functions that make a block from data: a path, matrices, a fuzzy system."""

STUDIES: dict[str, str] = {
    "fsmc_ballscrew": "leadscrew.studies.fsmc_ballscrew.study:STUDY",
    "grey_turning": "leadscrew.studies.grey_turning.study:STUDY",
    "npid_xytable": "leadscrew.studies.npid_xytable.study:STUDY",
    "sofnn_tangent": "leadscrew.studies.sofnn_tangent.study:STUDY",
    "vud_lathe": "leadscrew.studies.vud_lathe.study:STUDY",
}
"""The published systems."""

BLOCK_GROUP, STUDY_GROUP = "leadscrew.blocks", "leadscrew.studies"


def _plug_ins(group: str) -> dict[str, EntryPoint]:
    from importlib import metadata

    return {point.name: point for point in metadata.entry_points(group=group)}


def _from_table(target: str) -> Any:
    module, attribute = target.split(":")
    return getattr(import_module(module), attribute)


def _from_plug_in(point: EntryPoint) -> Any:
    try:
        return point.load()
    except Exception as error:
        raise LeadscrewError(
            f"the plug-in {point.name!r} ({point.value}) cannot be loaded: {type(error).__name__}: {error}"
        ) from error


def _find(name: str, table: dict[str, str], group: str, what: str) -> Any:
    if name in table:
        return _from_table(table[name])
    points = _plug_ins(group)
    if name in points:
        return _from_plug_in(points[name])
    raise NameUnknown(f"there is no {what} {name!r}{nearest(name, [*table, *points])}")


def block(name: str) -> Any:
    """What stands under the name of a block: in the table, or an installed plug-in.

    Raises:
        NameUnknown: no such block; names the nearest.
        BlockError: it is made from data by a function.
    """
    if name in FACTORIES:
        raise BlockError(
            f"{name} is made from data by a function: call {FACTORIES[name].replace(':', '.')}(...) in a file"
        )
    return _find(name, BLOCKS, BLOCK_GROUP, "block")


def study(name: str) -> Any:
    """What stands under the name of a study.

    Raises:
        NameUnknown: no such study; names the nearest.
    """
    return _find(name, STUDIES, STUDY_GROUP, "study")


def block_names() -> list[str]:
    """Names of all blocks: ours, then those of plug-ins."""
    return [*BLOCKS, *(n for n in _plug_ins(BLOCK_GROUP) if n not in BLOCKS)]


def study_names() -> list[str]:
    """Names of all studies: ours, then those of plug-ins."""
    return [*STUDIES, *(n for n in _plug_ins(STUDY_GROUP) if n not in STUDIES)]


def blocks() -> dict[str, Block]:
    """Every block by name."""
    return {name: block(name) for name in block_names()}


def factories() -> dict[str, Any]:
    """The functions that make a block from data, by name."""
    return {name: _from_table(target) for name, target in FACTORIES.items()}


def factory_kind(name: str) -> str:
    """The kind of block that a function of :data:`FACTORIES` makes: its folder says it, else its own name."""
    from leadscrew.kernel.block import KINDS

    module, function = FACTORIES[name].split(":")
    folder = module.split(".")[1].removesuffix("s")
    return folder if folder in KINDS else function
