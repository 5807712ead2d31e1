"""The profile of a machine without one of its own: every button does something, in the machine's units."""

from dataclasses import replace

import numpy as np
import pytest

from leadscrew.machine import write
from leadscrew.operate.operated import Operated, Start
from leadscrew.operate.profiles import general
from tests.machine.test_machine_file import EMPS

TABLE = replace(EMPS, name="table", noise=0.0)


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """A table from a machine file, on the Python engine; its sensor has no noise."""
    path = tmp_path_factory.mktemp("machine") / "table.toml"
    write(path, TABLE)
    return Operated(Start(str(path), "ours.cascade", "move", engine="python"))


def test_every_disturbance_of_a_machine_file_does_something_as_it_is_proposed(table):
    assert [d.name for d in table.profile.disturbances] == ["move_to", "load_pulse", "noise"]
    for found in table.profile.disturbances:
        plain, disturbed = table.restarted(), table.restarted()
        for operated in (plain, disturbed):
            operated.advance(60)
        disturbed.disturb(found.name)
        a, b = (operated.advance(120)[0] for operated in (plain, disturbed))
        moved = np.abs(a - b)[:, table.columns.index("actual.position")].max()
        assert moved > 0.0, found.name


def test_a_machine_file_s_load_and_noise_are_proposed_in_its_units(table):
    fields = {d.name: d.fields[0] for d in table.profile.disturbances}
    assert (fields["load_pulse"].value, fields["load_pulse"].unit) == (pytest.approx(0.1 * 10.0 * 35.15), "N")
    assert (fields["noise"].value, fields["noise"].unit) == (pytest.approx(1.0), "um")  # one count of 0.001 mm
    assert fields["move_to"].unit == "mm" and fields["move_to"].low < fields["move_to"].value < fields["move_to"].high
    (load,) = [plot for plot in table.profile.plots if plot.title == "Load"]
    assert load.unit == "N"


def test_a_machine_whose_force_is_not_known_is_loaded_in_the_unit_of_its_drive(tmp_path):
    path = tmp_path / "plain.toml"
    write(path, replace(TABLE, parameters={**TABLE.parameters, "force_per_drive": 1.0}))
    pulse = general.profile(str(path)).disturbance("load_pulse").fields[0]
    assert (pulse.value, pulse.unit) == (pytest.approx(1.0), "V")


def test_a_step_and_a_load_on_the_drive_are_proposed_from_what_the_lathe_has():
    fields = {d.name: d.fields[0] for d in general.profile("vud_lathe").disturbances}
    assert fields["go_to"].value == pytest.approx(-45.0)  # the step goes to -50 mm: a tenth back
    assert (fields["load_pulse"].value, fields["load_pulse"].high) == (0.1, 1.0)  # the duty is 1 at most


def test_lines_have_names_in_words(table):
    labels = [[t.label for t in plot.traces] for plot in table.profile.plots]
    assert labels == [
        ["command", "actual", "feedback"],
        ["true error", "error as measured"],
        ["output", "applied"],
        ["load"],
    ]
