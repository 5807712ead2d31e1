"""Every controller to every target: exported, and verified with all that the machine has."""

import numpy as np
import pytest

from leadscrew import catalogue
from leadscrew.export.folder import TARGETS, verify
from leadscrew.export.verdict import IDENTICAL, NOT_RUN
from tests.budget import WHOLE
from tests.export.table import ROWS, complete, exported, folder_of, loop_of


def marks(row, quick):
    """A row is exported and recorded once for all its targets, where xdist keeps groups together."""
    return [] if quick else [pytest.mark.slow, pytest.mark.xdist_group(f"export {row}")]


TURN = ("hal", "fmu2", "hal", "fmu3", "hal", "c99")
"""Where the rows go in turn; what goes to HAL is judged as C99 too."""


def asked(number, row, target):
    """Every row goes to at least one target."""
    return WHOLE or target == TURN[number % len(TURN)] or target in ROWS[row].quick


CELLS = [
    pytest.param(row, target, marks=marks(row, target in ROWS[row].quick), id=f"{row}-{target}")
    for number, row in enumerate(ROWS)
    for target in TARGETS
    if asked(number, row, target)
]

JUDGES = {"c99": 3, "hal": 5, "fmu2": 3, "fmu3": 3}
"""How many verdicts there are where nothing but clang is missing."""


@pytest.mark.parametrize(("row", "target"), CELLS)
def test_everything_that_runs_an_export_gives_the_bits_of_the_simulation(row, target, tmp_path):
    found = verify(folder_of(row, target, tmp_path))
    cycles = round(ROWS[row].seconds / loop_of(row).period)
    judged = [v for v in found if v.verdict != NOT_RUN]
    assert [(v.target, v.verdict, v.cycles, v.worst) for v in judged] == [
        (v.target, IDENTICAL, cycles, 0.0) for v in judged
    ], [v.note for v in judged]
    complete(found)
    in_single = ROWS[row].real == "float" and target == "hal"  # there the closed loop is not comparable
    assert sum("clang" not in v.target for v in judged) == JUDGES[target] - in_single


RECORDED = [pytest.param(row, marks=marks(row, ROWS[row].quick and n % 3 == 0)) for n, row in enumerate(ROWS)]


@pytest.mark.parametrize("row", RECORDED)
def test_the_recorded_run_asks_something_of_the_controller(row):
    core, record = exported(row)
    assert len(record.outputs) >= 300
    assert len(np.unique(record.outputs)) > 40
    assert np.ptp(core.machine_outputs(record)) > 0.0


def test_every_controller_of_the_catalogue_has_a_row():
    controllers = {b.name for b in catalogue.blocks().values() if b.kind == "controller" and not b.continuous}
    assert len(controllers) >= 9
    made = ("fuzzy", *catalogue.FACTORIES)
    rows = [row for row in ROWS if not any(maker in row for maker in made)]
    assert controllers == {loop_of(row).blocks["controller"].name for row in rows}
