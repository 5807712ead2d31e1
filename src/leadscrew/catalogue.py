"""Every block and study by name: plain tables, and the look-up that also takes plug-ins and a user's own file.

Adding a block is one file and one row here. An installed package joins through the entry points ``leadscrew.blocks``
and ``leadscrew.studies``; a file of one's own is named ``path/file.py:name`` wherever a name is asked for, and a fuzzy
system's file (``.fis``, ``.fll``, ``.fcl``, ``.xml``) or a controller file (``.toml``) wherever a controller is.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from leadscrew.kernel.errors import BlockError, LeadscrewError, NameUnknown
from leadscrew.kernel.sheet import nearest

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from leadscrew.kernel.block import Block
    from leadscrew.studies.study import Study

BLOCKS: dict[str, str] = {
    # references
    "chirp": "leadscrew.references.chirp:chirp",
    "cut_line": "leadscrew.references.cut_line:cut_line",
    "cutting_force": "leadscrew.references.cutting_program:cutting_force",
    "cutting_program": "leadscrew.references.cutting_program:cutting_program",
    "eased_sine": "leadscrew.references.eased_sine:eased_sine",
    "eased_sine_motion": "leadscrew.references.eased_sine:eased_sine_motion",
    "filtered_step": "leadscrew.references.filtered_step:filtered_step",
    "lathe_program": "leadscrew.references.lathe_program:lathe_program",
    "log_chirp": "leadscrew.references.chirp:log_chirp",
    "quintic": "leadscrew.references.quintic:quintic",
    "ramp": "leadscrew.references.ramp:ramp",
    "ramp_motion": "leadscrew.references.ramp:ramp_motion",
    "s_curve": "leadscrew.references.s_curve:s_curve",
    "sine": "leadscrew.references.sine:sine",
    "sine_motion": "leadscrew.references.sine:sine_motion",
    "step": "leadscrew.references.step:step",
    "trapezoid": "leadscrew.references.trapezoid:trapezoid",
    # sensors
    "axis_encoder": "leadscrew.sensors.axis_encoder:axis_encoder",
    "axis_reading": "leadscrew.sensors.axis_reading:axis_reading",
    "cut_camera": "leadscrew.sensors.cut_camera:cut_camera",
    "cut_reading": "leadscrew.sensors.cut_camera:cut_reading",
    "dual_encoder": "leadscrew.sensors.dual_encoder:dual_encoder",
    "encoder_count": "leadscrew.sensors.encoder_count:encoder_count",
    "faulty_load_cell": "leadscrew.sensors.faulty_load_cell:faulty_load_cell",
    "filtered_ruler": "leadscrew.sensors.filtered_ruler:filtered_ruler",
    "grating_count": "leadscrew.sensors.grating_count:grating_count",
    "grating_counter": "leadscrew.sensors.grating.counter:grating_counter",
    "grating_ruler": "leadscrew.sensors.grating.ruler:grating_ruler",
    "ideal": "leadscrew.sensors.ideal:ideal",
    "lag": "leadscrew.sensors.lag:lag",
    "lathe_reading": "leadscrew.sensors.load_cell:lathe_reading",
    "lathe_sensors": "leadscrew.sensors.lathe_sensors:lathe_sensors",
    "load_cell": "leadscrew.sensors.load_cell:load_cell",
    "noisy": "leadscrew.sensors.noisy:noisy",
    "noisy_encoder": "leadscrew.sensors.noisy_count:noisy_encoder",
    "noisy_grating": "leadscrew.sensors.noisy_count:noisy_grating",
    "noisy_position": "leadscrew.sensors.noisy:noisy_position",
    "noisy_ruler": "leadscrew.sensors.noisy_ruler:noisy_ruler",
    "ruler": "leadscrew.sensors.ruler:ruler",
    "screw_encoder": "leadscrew.sensors.screw_encoder:screw_encoder",
    # controllers
    "axis_cascade": "leadscrew.controllers.axis_cascade:axis_cascade",
    "cascade_ppi": "leadscrew.controllers.cascade_ppi:cascade_ppi",
    "constant_force": "leadscrew.controllers.force.constant_force:constant_force",
    "csmc": "leadscrew.controllers.sliding.complementary:csmc",
    "csmc_ideal": "leadscrew.controllers.sliding.continuous:csmc_ideal",
    "curvature_feed_forward": "leadscrew.controllers.tangent.curvature_feed_forward:curvature_feed_forward",
    "curvature_network": "leadscrew.controllers.tangent.curvature_network:curvature_network",
    "duty_pd": "leadscrew.controllers.vud.duty_pd:duty_pd",
    "duty_pd_observed": "leadscrew.controllers.vud.duty_pd_observed:duty_pd_observed",
    "duty_pid": "leadscrew.controllers.vud.duty_pid:duty_pid",
    "fnn": "leadscrew.controllers.sofnn.fixed:fnn",
    "fsmc": "leadscrew.controllers.sliding.fuzzy:fsmc",
    "fsmc_ideal": "leadscrew.controllers.sliding.continuous:fsmc_ideal",
    "fsmc_printed": "leadscrew.controllers.sliding.fuzzy:fsmc_printed",
    "fsmc_printed_ideal": "leadscrew.controllers.sliding.continuous:fsmc_printed_ideal",
    "gpfc": "leadscrew.controllers.grey_fuzzy.gpfc:gpfc",
    "low_pass": "leadscrew.controllers.filters:low_pass",
    "notch": "leadscrew.controllers.filters:notch",
    "npid": "leadscrew.controllers.npid:npid",
    "npid_after": "leadscrew.controllers.npid_after:npid_after",
    "npid_slope": "leadscrew.controllers.npid_slope:npid_slope",
    "npid_split": "leadscrew.controllers.npid_split:npid_split",
    "pd_dob": "leadscrew.controllers.pd_dob:pd_dob",
    "pd_learned": "leadscrew.controllers.pd_learned:pd_learned",
    "pid": "leadscrew.controllers.pid:pid",
    "pi_incremental": "leadscrew.controllers.grey_fuzzy.pi_incremental:pi_incremental",
    "power_law": "leadscrew.controllers.vud.power_law:power_law",
    "power_law_inversion": "leadscrew.controllers.force.power_law_inversion:power_law_inversion",
    "smc": "leadscrew.controllers.sliding.conventional:smc",
    "smc_ideal": "leadscrew.controllers.sliding.continuous:smc_ideal",
    "smc_integral": "leadscrew.controllers.sliding.integral:smc_integral",
    "smc_integral_ideal": "leadscrew.controllers.sliding.continuous:smc_integral_ideal",
    "smith": "leadscrew.controllers.grey_fuzzy.smith:smith",
    "sofc": "leadscrew.controllers.sofnn.standard:sofc",
    "sofnn": "leadscrew.controllers.sofnn.network:sofnn",
    "sofnn_all_weights": "leadscrew.controllers.sofnn.all_weights:sofnn_all_weights",
    "super_twisting": "leadscrew.controllers.sliding.super_twisting:super_twisting",
    "tangent_dob": "leadscrew.controllers.tangent.tangent_dob:tangent_dob",
    "tfc": "leadscrew.controllers.grey_fuzzy.tfc:tfc",
    "torque_pid": "leadscrew.controllers.torque_pid:torque_pid",
    "vud": "leadscrew.controllers.vud.literal:vud",
    "vud_beta_e": "leadscrew.controllers.vud.error_factor:vud_beta_e",
    "vud_family": "leadscrew.controllers.vud.family:vud_family",
    "vud_fast": "leadscrew.controllers.vud.fast:vud_fast",
    "vud_incremental": "leadscrew.controllers.vud.incremental:vud_incremental",
    "vud_integral_factor": "leadscrew.controllers.vud.integral_factor:vud_integral_factor",
    "vud_scaled": "leadscrew.controllers.vud.scaled:vud_scaled",
    # actuators
    "dac": "leadscrew.actuators.dac:dac",
    "dead_zone": "leadscrew.actuators.dead_zone:dead_zone",
    "lathe_dac": "leadscrew.actuators.dac:lathe_dac",
    "limits": "leadscrew.actuators.limits:limits",
    "offset": "leadscrew.actuators.offset:offset",
    "pwm": "leadscrew.actuators.pwm:pwm",
    "saturation": "leadscrew.actuators.saturation:saturation",
    "stiction": "leadscrew.actuators.stiction:stiction",
    "torque_drive": "leadscrew.actuators.torque_drive:torque_drive",
    # plants
    "backlash_axis": "leadscrew.plants.backlash:backlash_axis",
    "backlash_two_mass": "leadscrew.plants.backlash_two_mass:backlash_two_mass",
    "ballscrew_axial": "leadscrew.plants.ballscrew_axial:ballscrew_axial",
    "ballscrew_backlash": "leadscrew.plants.ballscrew_backlash:ballscrew_backlash",
    "ballscrew_gms": "leadscrew.plants.ballscrew_gms:ballscrew_gms",
    "ballscrew_play": "leadscrew.plants.ballscrew_play:ballscrew_play",
    "ballscrew_stage": "leadscrew.plants.ballscrew_stage:ballscrew_stage",
    "ballscrew_stage_fixed": "leadscrew.plants.ballscrew_stage_fixed:ballscrew_stage_fixed",
    "flexible_cut": "leadscrew.plants.flexible_cut:flexible_cut",
    "lathe_screw": "leadscrew.plants.lathe_screw:lathe_screw",
    "lathe_servo": "leadscrew.plants.lathe_servo:lathe_servo",
    "lathe_servo_limited": "leadscrew.plants.lathe_servo_limited:lathe_servo_limited",
    "mass_dahl": "leadscrew.plants.mass_dahl:mass_dahl",
    "mass_lugre": "leadscrew.plants.mass_lugre:mass_lugre",
    "mass_maxwell_slip": "leadscrew.plants.mass_maxwell_slip:mass_maxwell_slip",
    "mass_stribeck": "leadscrew.plants.mass_stribeck:mass_stribeck",
    "servo_axis": "leadscrew.plants.servo_axis:servo_axis",
    "servo_axis_lugre": "leadscrew.plants.servo_axis_lugre:servo_axis_lugre",
    "turning": "leadscrew.plants.turning.process:turning",
    "turning_lathe": "leadscrew.plants.turning_lathe:turning_lathe",
    "xy_table": "leadscrew.plants.xy_table:xy_table",
    "xy_table_lugre": "leadscrew.plants.xy_table_lugre:xy_table_lugre",
    "xy_table_two_mass": "leadscrew.plants.xy_table_two_mass:xy_table_two_mass",
    "xy_table_cutting": "leadscrew.plants.xy_table_cutting:xy_table_cutting",
    # disturbances
    "cut_load": "leadscrew.disturbances.cut_load:cut_load",
    "five_sines": "leadscrew.disturbances.five_sines:five_sines",
    "five_sines_pulse": "leadscrew.disturbances.five_sines_pulse:five_sines_pulse",
    "hard_spot": "leadscrew.disturbances.hard_spot:hard_spot",
    "kicked_load": "leadscrew.disturbances.kicked_load:kicked_load",
    "pulse_load": "leadscrew.disturbances.pulse_load:pulse_load",
    "sine_load": "leadscrew.disturbances.sine_load:sine_load",
    "step_load": "leadscrew.disturbances.step_load:step_load",
    "wandering_spindle": "leadscrew.disturbances.wandering_spindle:wandering_spindle",
    "white_noise": "leadscrew.disturbances.white_noise:white_noise",
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

MAKERS: dict[str, str] = {
    "adaptive_resonant": "leadscrew.controllers.adaptive_resonant:adaptive_resonant",
    "biquad": "leadscrew.controllers.biquad:biquad",
    "dead_zone_inverse": "leadscrew.controllers.dead_zone_inverse:dead_zone_inverse",
    "depth_feed_forward": "leadscrew.controllers.force:depth_feed_forward",
    "feed_forward_table": "leadscrew.controllers.feed_forward_table:feed_forward_table",
    "feed_override": "leadscrew.controllers.guard:feed_override",
    "force_guard": "leadscrew.controllers.guard:force_guard",
    "friction_feed_forward": "leadscrew.controllers.friction_feed_forward:friction_feed_forward",
    "friction_test": "leadscrew.references.friction_test:friction_test",
    "fuzzy.controller": "leadscrew.fuzzy:controller",
    "gain_normalised": "leadscrew.controllers.force:gain_normalised",
    "input_dob": "leadscrew.controllers.input_dob:input_dob",
    "inverse_feed_forward": "leadscrew.controllers.inverse_feed_forward:inverse_feed_forward",
    "lathe_loops": "leadscrew.controllers.lathe_loops:lathe_loops",
    "learned_feed_forward": "leadscrew.controllers.learned_feed_forward:learned_feed_forward",
    "look_ahead": "leadscrew.controllers.look_ahead:look_ahead",
    "logged_command": "leadscrew.references.logged:logged_command",
    "path": "leadscrew.references.path:path",
    "path_from_gcode": "leadscrew.references.gcode:path_from_gcode",
    "repetitive": "leadscrew.controllers.repetitive:repetitive",
    "resonant": "leadscrew.controllers.resonant:resonant",
    "series": "leadscrew.controllers.series:series",
    "stairs": "leadscrew.references.stairs:stairs",
    "state_space": "leadscrew.plants.linear:state_space",
    "taught_alone": "leadscrew.controllers.tangent.taught_offset:taught_alone",
    "taught_offset": "leadscrew.controllers.tangent.taught_offset:taught_offset",
    "tracking_differentiator": "leadscrew.controllers.tracking_differentiator:tracking_differentiator",
    "transfer_function": "leadscrew.plants.linear:transfer_function",
    "waypoints": "leadscrew.references.waypoints:waypoints",
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
    if "." in name:
        from leadscrew import userfile

        if userfile.is_reference(name) or (group == BLOCK_GROUP and userfile.is_controller_file(name)):
            return userfile.load(name)
    if name in table:
        return _from_table(table[name])
    points = _plug_ins(group)
    if name in points:
        return _from_plug_in(points[name])
    raise NameUnknown(f"there is no {what} {name!r}{nearest(name, [*table, *points])}")


def block(name: str, kind: str | None = None) -> Block:
    """The block of a name: from the table, an installed plug-in, ``path/file.py:name``, or a fuzzy system's file.

    Raises:
        NameUnknown: no such block; names the nearest.
        BlockError: what is there is not a block, or not of that ``kind``.
        DataError: the file is missing or does not load.
    """
    from leadscrew.kernel.block import Block

    if name in MAKERS:
        raise BlockError(
            f"{name} is made from data by a function: call {MAKERS[name].replace(':', '.')}(...) in a file"
        )
    found = _find(name, BLOCKS, BLOCK_GROUP, "block")
    if not isinstance(found, Block):
        raise BlockError(
            f"{name} is not a block but an object of type {type(found).__name__}; decorate its step: @controller(...)"
        )
    if kind is not None and found.kind != kind:
        raise BlockError(f"{name} is a {found.kind}, not a {kind}")
    return found


def study(name: str) -> Study:
    """The study of a name: from the table, an installed plug-in, a machine file (``.toml``), or ``path/file.py:name``.

    Raises:
        NameUnknown: no such study; names the nearest.
        BlockError: what is there is not a study.
        DataError: the file is missing or does not load.
    """
    from leadscrew.studies.study import Study

    if name.endswith(".toml"):
        from leadscrew.machine.axis_study import study as machine

        return machine(name)
    found = _find(name, STUDIES, STUDY_GROUP, "study")
    if not isinstance(found, Study):
        raise BlockError(f"{name} is not a study but an object of type {type(found).__name__}")
    return found


def block_names() -> list[str]:
    """Names of all blocks: ours, then those of plug-ins."""
    return [*BLOCKS, *(n for n in _plug_ins(BLOCK_GROUP) if n not in BLOCKS)]


def study_names() -> list[str]:
    """Names of all studies: ours, then those of plug-ins."""
    return [*STUDIES, *(n for n in _plug_ins(STUDY_GROUP) if n not in STUDIES)]


def blocks() -> dict[str, Block]:
    """Every block by name."""
    return {name: block(name) for name in block_names()}


def makers() -> dict[str, Any]:
    """The functions that make a block from data, by name."""
    return {name: _from_table(target) for name, target in MAKERS.items()}


def maker_kind(name: str) -> str:
    """The kind of block that a function of :data:`MAKERS` makes: its folder says it, else its own name."""
    from leadscrew.kernel.block import KINDS

    module, function = MAKERS[name].split(":")
    folder = module.split(".")[1].removesuffix("s")
    return folder if folder in KINDS else function
