"""What the operator of each machine finds on the screen, and what can be done to the machine."""

import subprocess
import sys

import pytest

from leadscrew import resolve
from leadscrew.experiment import Experiment
from leadscrew.figures.signals import signal_unit
from leadscrew.operate.profile import fitted
from leadscrew.operate.profiles import profile_of
from leadscrew.util.errors import NameUnknown, ValueRefused
from tests.operate.playing import STUDIES, loop_of

LENGTHS = {"mm": 1.0, "um": 1e-3, "nm": 1e-6}
SCALES = {"rad": 1.0, "urad": 1e-6}, {"V": 1.0, "mV": 1e-3}, {"1": 1.0, "": 1.0, "%": 1e-2}, {"1/mm": 1.0, "1/m": 1e-3}

LOADS = {"vud_lathe": "1", "npid_xytable": "V", "fsmc_ballscrew": "N m", "grey_turning": "1"}


@pytest.fixture(scope="module", params=STUDIES)
def machine(request):
    """Profile, fitted to its loop, and the loop."""
    profile = profile_of(request.param)
    loop = loop_of(request.param)
    return profile, fitted(profile, loop), loop


def own_unit(loop, column):
    """The unit of a column as its NamedTuple, else the blocks of the loop, say it."""
    from leadscrew.kernel.layout import is_branch
    from leadscrew.kernel.parameters import entries

    root, _, rest = column.partition(".")
    example = loop.signals.get({"disturbance": "load", "true_error": "actual", "error": "feedback"}.get(root, root))
    block = loop.blocks.get(root)
    for said in (example, None if block is None or block.state is None else loop.start_state(block)):
        if is_branch(said):
            for entry in entries(said):
                if entry.key == rest and entry.unit:
                    return entry.unit
    if root == "disturbance":
        return {"vud_lathe": "1", "npid_xytable": "V", "fsmc_ballscrew": "N m", "grey_turning": "1"}[
            loop.name.split()[0]
        ]
    return "1" if root == "controller" else signal_unit(loop, column)


def test_every_line_is_drawn_in_a_unit_that_its_column_has_after_the_factor(machine):
    _, profile, loop = machine
    for plot in profile.plots:
        for trace in plot.traces:
            assert trace.unit == plot.unit, trace
            unit = own_unit(loop, trace.signal)
            if unit == trace.unit:
                assert trace.factor == 1.0, trace
                continue
            scale = next(s for s in (LENGTHS, *SCALES) if unit in s and trace.unit in s)
            assert trace.factor == pytest.approx(scale[unit] / scale[trace.unit]), (trace, unit)


def test_command_machine_error_and_output_are_on_the_screen(machine):
    _, profile, _ = machine
    roles = [t.role for plot in profile.plots for t in plot.traces]
    assert {"command", "actual", "error", "output", "disturbance"} <= set(roles)
    assert roles.count("error") == 1 == roles.count("output")
    for plot in profile.plots:
        labels = [t.label for t in plot.traces]
        assert len(set(labels)) == len(labels), plot.title


def test_bands_say_whose_tolerance_they_are(machine):
    _, profile, _ = machine
    bands = [b for plot in profile.plots for b in plot.bands]
    assert bands
    for band in bands:
        assert band.low < band.high
        assert "paper" in band.doc or "largest" in band.doc, band.doc
        assert 0 < len(band.label) <= 16, f"{band.label!r} has no room beside the title of its plot"


BANDS = {
    "vud_lathe": [("Error", -2.0, 2.0)],  # Figure 12: 2 um after 2 s
    "grey_turning": [  # section 5.2: 1.0 % steady, 1.5 % overshoot, both of 150 N
        ("Cutting force", -0.010 * 150.0, 0.010 * 150.0), ("Cutting force", 0.010 * 150.0, 0.015 * 150.0),
        ("Force error", -0.010 * 150.0, 0.010 * 150.0),
    ],
    "fsmc_ballscrew": [("Error", -1.0, 1.0)],  # our own: 1 um
    "sofnn_tangent": [
        ("Deviation of the cut", -0.25, 0.25), ("Error", -0.25, 0.25), ("Offset of the blade", -15.0, 15.0),
    ],
    "npid_xytable": [("Error", -3.0, 3.0)],  # equation (2): e_max
}  # fmt: skip
"""Plot and bounds of every band, in the unit of the plot, from the papers."""


def test_bands_are_as_wide_as_the_papers_say(machine):
    profile, _, loop = machine
    found = [(plot.title, b.low, b.high) for plot in profile.plots for b in plot.bands]
    assert found == [(title, pytest.approx(a), pytest.approx(b)) for title, a, b in BANDS[profile.study]]
    if profile.study == "npid_xytable":
        assert found[0][2] == pytest.approx(loop.parameters["controller.e_max"])
    if profile.study == "grey_turning":
        assert loop.parameters["reference.force"] == 150.0


def test_numbers_above_the_plots_are_the_machine_s_own_in_a_unit_after_their_factor(machine):
    profile, fit, loop = machine
    assert 5 <= len(fit.readouts) <= 6
    assert len({r.label for r in fit.readouts}) == len(fit.readouts)
    columns = set(loop.program.plan.columns)
    known = {t.signal: (t.factor, t.unit) for plot in fit.plots for t in plot.traces}
    for readout in fit.readouts:
        assert readout.source in columns or readout.source in loop.sheet, readout
        if readout.source in known and readout.unit == known[readout.source][1] and not readout.per:
            assert readout.factor == known[readout.source][0], readout
    assert {r.label for r in profile.readouts} >= {r.label for r in fit.readouts}


def test_force_spindle_speed_and_depth_of_cut_are_seen_at_once_as_at_the_paper_s_lathe():
    """Section 5.2 and Figure 10a of the paper."""
    for controller in ("corrected.gpfc_b_s6", "ours.inversion"):
        loop = loop_of("grey_turning", controller)
        found = {r.label: r for r in fitted(profile_of("grey_turning"), loop).readouts}
        assert list(found) == ["force", "set force", "spindle", "depth of cut", "feed rate", "feed per rev"]
        assert loop.parameters[found["spindle"].source] == 1200.0
        assert found["feed per rev"].per == found["spindle"].source
        assert found["set force"].source in loop.program.plan.columns


def test_a_readout_that_the_loop_lacks_is_left_out():
    rough = fitted(profile_of("npid_xytable"), loop_of("npid_xytable", "paper.pid", "sine_1mm_on_friction_low"))
    assert "spindle" not in [r.label for r in rough.readouts]
    assert "following error" in [r.label for r in rough.readouts]


def test_a_ball_bar_is_offered_only_where_two_axes_can_make_a_circle():
    assert [name for name in STUDIES if profile_of(name).circle] == ["fsmc_ballscrew"]


def test_a_machine_starts_with_a_controller_and_a_scenario_of_its_study(machine):
    profile, _, _ = machine
    study = resolve.study(profile.study)
    assert profile.controller in study.controllers
    assert profile.scenario in study.scenarios
    assert 0.0 < profile.window_s <= 20.0
    assert "end" in profile.notes


def test_every_disturbance_of_the_first_screen_can_be_set_in_the_run(machine):
    from leadscrew.operate.settable import at_start

    _, profile, loop = machine
    fixed = at_start(loop, Experiment(profile.study, profile.controller, profile.scenario).settable())
    values = loop.parameters
    for found in profile.disturbances:
        assert not set(found.needs) & set(fixed), found.name
        for extreme in ("low", "value", "high"):
            changes = found.changes({f.name: getattr(f, extreme) for f in found.fields}, 3.0, values)
            assert changes[0][0] == 0.0
            for delay, wanted in changes:
                assert 0.0 <= delay <= 600.0
                assert loop.using(wanted).fits(loop.program), (found.name, wanted)


def test_a_pulse_of_a_parameter_ends_at_what_it_was(machine):
    _, profile, loop = machine
    values = loop.parameters
    for found in profile.disturbances:
        changes = found.changes({}, 3.0, values)
        for key in changes[-1][1] if len(changes) > 1 else ():
            assert changes[-1][1][key] == values[key], (found.name, key)


def test_a_disturbance_out_of_its_bounds_is_refused_with_the_bounds(machine):
    _, profile, loop = machine
    for found in profile.disturbances:
        for field in found.fields:
            for bad in (field.low - 1.0, field.high + 1.0, float("nan"), float("inf"), "1", True, None):
                with pytest.raises(ValueRefused, match=field.name):
                    found.changes({field.name: bad}, 0.0, loop.parameters)
        with pytest.raises(NameUnknown, match=r"no field 'siz'"):
            found.changes({"siz": 1.0}, 0.0, loop.parameters)
    with pytest.raises(NameUnknown, match="no disturbance 'earthquake'"):
        profile.disturbance("earthquake")


def test_names_of_a_machine_s_disturbances_are_its_own(machine):
    profile, _, _ = machine
    names = [d.name for d in profile.disturbances]
    assert len(set(names)) == len(names)
    for found in profile.disturbances:
        assert found.doc.endswith(".")
        for field in found.fields:
            assert field.low <= field.value <= field.high
            assert field.doc


def test_lines_that_a_controller_lacks_are_left_out():
    profile = profile_of("vud_lathe")
    titles = [p.title for p in fitted(profile, loop_of("vud_lathe", "ours.pd")).plots]
    assert "Contraction of the universes" not in titles
    assert "Position" in titles
    rough = fitted(profile_of("npid_xytable"), loop_of("npid_xytable", "paper.pid", "sine_1mm_on_friction_low"))
    assert "friction" in [d.name for d in rough.disturbances]
    assert "spindle_speed" not in [d.name for d in rough.disturbances]


def test_a_controller_that_reads_the_programme_is_told_of_a_programmed_depth_only():
    loop = loop_of("grey_turning", "ours.inversion")
    profile = fitted(profile_of("grey_turning"), loop)
    told = profile.disturbance("depth_step").changes({"step": -0.3}, 1.0, loop.parameters)
    hidden = profile.disturbance("stock_step").changes({"step": -0.3, "for_s": 0.0}, 1.0, loop.parameters)
    assert set(told[0][1]) == {"plant.depth.start", "reference.depth.start"}
    assert hidden == [(0.0, {"plant.depth.start": 0.7})]


def test_a_profile_is_read_without_plotting_or_web():
    code = (
        "import sys; from leadscrew.operate.profiles import profile_of; "
        f"[profile_of(n) for n in {STUDIES!r}]; "
        "sys.exit(any(m in sys.modules for m in ('matplotlib', 'scipy', 'starlette', 'pyarrow')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
