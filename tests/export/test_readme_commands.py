"""What the README of an export says to type, typed."""

import re
import subprocess

import numpy as np
import pytest

from leadscrew.export import hal_run
from tests.export.hal_bench import needed, shown
from tests.export.table import exported, folder_of

ROWS = ("vud_beta_e", "npid", "smc")


@pytest.mark.parametrize("row", ROWS)
def test_check_and_example_build_and_run(row, tmp_path):
    folder = folder_of(row, "c99", tmp_path)
    commands = [x.strip() for x in (folder / "README.md").read_text().splitlines() if x.startswith("    cc ")]
    assert [c.rsplit("&& ", 1)[1] for c in commands] == ["./check", "./example"]
    check, example = (
        subprocess.run(c, shell=True, cwd=folder, capture_output=True, text=True, check=True).stdout for c in commands
    )
    core, record = exported(row)
    assert check.startswith(f"cycles {len(record.outputs)} different 0 worst 0")
    assert example.count("\n") == 10 and "fault" not in example and "nan" not in example
    assert f" {core.inputs[0].unit}, output " in example


@pytest.mark.slow
@pytest.mark.parametrize("row", ROWS)
def test_the_demonstrations_run_without_a_fault(row, tmp_path):
    needed()
    folder = folder_of(row, "hal", tmp_path)
    about = (folder / "README.md").read_text()
    installed = re.findall(r"sudo halcompile --install (\S+)\.comp\nhalrun (\S+)\n", about)
    assert installed == [("ours", "ours_sim.hal"), ("ours_plant", "ours_loop.hal")]
    size = {"ours_sim.hal": 10.0, "ours_loop.hal": np.abs(exported(row)[1].inputs[:, 0]).max()}
    with hal_run.workplace() as place:
        for component, script in installed:
            hal_run.install(place, folder, component)
            for speed in (30, 10, 3):  # a machine with other work to do may not keep up with the first
                text = shown(hal_run.run(place, (folder / script).read_text(), speed=speed))
                found = re.findall(r"float (?:OUT|IN) (\S+) ours\.0\.(\S+)", text)
                pins = {name: float(value) for value, name in found}
                if pins["feedback"] != 0.0 and abs(pins["error"]) < 0.1 * size[script]:
                    break
            assert "bit OUT FALSE ours.0.fault " in text and "bit IN TRUE ours.0.enable" in text
            assert pins["feedback"] != 0.0 and abs(pins["error"]) < 0.1 * size[script]
