"""A log that is wrong is refused, or said to be odd, in one sentence with the place; the file is never touched.

By the library, since every command reads logs through it. What each command says is in `test_hostile_commands.py`.
"""

import re

import pytest

from leadscrew.logs import look_at, read_axis_log
from leadscrew.util.errors import DataError, LeadscrewError
from tests.identify.hostile import LOGS, ROW, listing, right, text, write

SAYS = {
    "position in mm under a header in m": r"--unit position=mm",
    "time in ms under a header in s": r"--unit time=ms",
    "force and position swapped": r"jumps",
    "standstill": r"at rest|constant",
    "two rows": r"has 2 samples",
    "zeros": r"0 in every sample",
    "zeros but for the time": r"0 in every sample",
    "a jump of the encoder": rf"jumps once, by \+0.004 m at row {ROW + 2} ",
    "a spike of the encoder": rf"jumps once, by \+0.004 m at row {ROW + 2} ",
    "a constant drive": r"the drive is 5 in every sample",
    "NaN in a cell": rf"row {ROW + 2}: the position",
    "an empty cell": rf"row {ROW + 2}: the drive",
    "a word in a column of numbers": rf"row {ROW + 2}, column 'position_m': 'broken'",
    "1e400 in a cell": rf"row {ROW + 2}: the drive is infinite",
    "inf in a cell": rf"row {ROW + 2}: the drive is infinite",
    "an empty file": r"is empty",
    "a header alone": r"no table of numbers",
    "bytes that are no text": r"is no text",
    "a time that steps back": rf"row {ROW + 2}: the time 1.997 s lies before",
    "a time that falls": r"the time falls",
    "a gap of two seconds": rf"a gap of 2.001 s before row {ROW + 2}",
    "a row that is too short": rf"row {ROW + 2}: 2 cells",
    "no columns of those names": r"--column drive=",
}
"""What is refused, and words that its sentence has."""
ODD = {
    "position in km under a header in m": r"1000|slow for an axis",
    "force with the other sign": r"backwards|sign",
    "a clipped drive": r"clipped",
    "force in kN under a header in N": r"wrong by 1000",
    "two columns of one name": r"position_m",
}
"""What may be read on, and what must be said of it."""


def test_every_wrong_log_is_expected_to_be_refused_or_said_to_be_odd():
    assert set(SAYS) | set(ODD) == set(LOGS)
    assert not set(SAYS) & set(ODD)


def test_the_right_log_is_read_without_a_word(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(text(right()))
    log = read_axis_log(path)
    assert [f for f in log.findings if f.severity != "note"] == []
    assert log.period == pytest.approx(1e-3)
    assert len(log.position) == 6000


@pytest.mark.parametrize("name", SAYS)
def test_a_wrong_log_is_refused_in_one_sentence_and_not_touched(tmp_path, name):
    path = write(tmp_path, name)
    before = listing(tmp_path)
    with pytest.raises(LeadscrewError) as stop:
        read_axis_log(path)
    said = str(stop.value)
    assert re.search(SAYS[name], said), said
    assert str(path) in said
    assert "\n" not in said and len(said) < 500
    assert listing(tmp_path) == before


@pytest.mark.parametrize("name", ODD)
def test_an_odd_log_is_read_with_a_word_about_it(tmp_path, name):
    path = write(tmp_path, name)
    before = listing(tmp_path)
    seen = look_at(path)
    said = " | ".join([*(f.sentence for f in seen.findings), *seen.table.notes])
    assert re.search(ODD[name], said), said
    assert listing(tmp_path) == before


def test_a_folder_and_a_file_that_is_not_there_are_refused_by_name(tmp_path):
    for path in (tmp_path, tmp_path / "gone.csv"):
        with pytest.raises(LeadscrewError) as stop:
            read_axis_log(path)
        assert str(path) in str(stop.value) and "\n" not in str(stop.value)


def test_arrays_given_to_the_library_are_never_changed():
    """The log has copies, and even those cannot be written to."""
    from leadscrew.logs.arrays import axis_log

    rows = right(2.0)
    time, force, position, command = (rows[:, i].copy() for i in range(4))
    log = axis_log(time, force, position, command)
    for mine, i in ((time, 0), (force, 1), (position, 2), (command, 3)):
        assert (mine == rows[:, i]).all() and mine.flags.writeable
    for name in ("time", "drive", "position", "command"):
        assert not getattr(log, name).flags.writeable


def test_arrays_of_unequal_length_are_refused():
    from leadscrew.logs.arrays import axis_log

    rows = right(2.0)
    with pytest.raises(DataError, match="1999"):
        axis_log(rows[:, 0], rows[:-1, 1], rows[:, 2])
