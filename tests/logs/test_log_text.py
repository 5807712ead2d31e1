"""Text tables as others write them: the csv module, NumPy, spreadsheets in other languages, recorders cut off."""

import csv
import math
import time as clock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from leadscrew.logs import read_axis_log, read_table
from leadscrew.logs.text import table_of
from leadscrew.util import reading
from leadscrew.util.errors import DataError

BODY = [[0.0, -1.25, 3e-7], [0.001, 2.5, -4e-7], [0.002, 1e6, 5.0], [0.003, 0.1, 7.0]]


def written(path, rows, delimiter=",", decimal=".", end="\n", header=("t", "pos", "u"), tail="", encoding="utf-8"):
    with path.open("w", newline="", encoding=encoding) as file:
        out = csv.writer(file, delimiter=delimiter, lineterminator=tail + end)
        if header:
            out.writerow(header)
        out.writerows([[repr(x).replace(".", decimal) for x in row] for row in rows])
    return path


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize(
    ("delimiter", "decimal"), [(",", "."), (";", "."), ("\t", "."), (" ", "."), ("|", "."), (";", ","), ("\t", ",")]
)
@pytest.mark.parametrize("header", [("t", "pos", "u"), ()])
def test_a_table_of_the_csv_module_reads_the_same_however_it_is_written(tmp_path, delimiter, decimal, end, header):
    table = read_table(written(tmp_path / "a.csv", BODY, delimiter, decimal, end, header))
    assert list(table.columns) == list(header or ("c1", "c2", "c3"))
    np.testing.assert_array_equal(np.column_stack(list(table.columns.values())), BODY)
    assert (table.notes == []) == bool(header)


def test_a_byte_order_mark_blank_lines_quotes_and_a_delimiter_at_the_end_do_not_disturb(tmp_path):
    text = '\ufeff"t [s]";"pos [mm]";"u";\r\n\r\n0;"1,5";2;\r\n0,1;2,5;;\r\n\r\n'
    (tmp_path / "a.csv").write_bytes(text.encode())
    table = read_table(tmp_path / "a.csv")
    assert table.units == {"t [s]": "s", "pos [mm]": "mm"}
    np.testing.assert_array_equal(table.columns["pos [mm]"], [1.5, 2.5])
    np.testing.assert_array_equal(table.columns["u"], [2.0, math.nan])
    np.testing.assert_array_equal(table.file_rows, [3, 4])


def test_comments_are_skipped_and_the_header_may_be_one_as_numpy_writes_it(tmp_path):
    values = np.array(BODY)
    np.savetxt(tmp_path / "a.txt", values, header="a test\nt pos_mm u", footer="end")
    table = read_table(tmp_path / "a.txt")
    assert list(table.columns) == ["t", "pos_mm", "u"] and table.units == {"pos_mm": "mm"}
    np.testing.assert_array_equal(np.column_stack(list(table.columns.values())), values)
    np.savetxt(tmp_path / "b.txt", values, comments="% ")
    assert list(read_table(tmp_path / "b.txt").columns) == ["c1", "c2", "c3"]


def test_units_may_stand_in_the_header_or_in_a_row_below_it():
    below = table_of("time,pos,u\ns,mm,V\n0,1,2\n1,2,3\n", "x")
    assert below.units == {"time": "s", "pos": "mm", "u": "V"} and below.rows == 2
    bracketed = table_of("time;pos;what\n[s];[mm];[inch of water]\n0;1;2\n1;2;3\n", "x")
    assert bracketed.units == {"time": "s", "pos": "mm", "what": "inch of water"}
    names = "t_ms,Position [mm],pos (mm),x_um,F / kN,v_mm_s,torque (Nm),load (%),Machining_Process,tau_cmd,a (b)"
    table = table_of(names + "\n" + "1,2,3,4,5,6,7,8,9,10,11\n" * 3, "x")
    assert list(table.units.values()) == ["ms", "mm", "mm", "um", "kN", "mm/s", "Nm", "%"]


def test_a_column_of_words_is_kept_and_a_word_among_numbers_is_named(tmp_path):
    table = table_of("t,phase\n0,Layer 1 Up\n1,end\n2,\n", "x")
    assert table.texts == {"phase": ["Layer 1 Up", "end", ""]}
    rows = [f"{k},{k}.5" for k in range(60)]
    rows[41] = "41,4l.5"
    with pytest.raises(DataError, match=r"a\.csv, row 43, column 'pos': '4l\.5' is not a number"):
        (tmp_path / "a.csv").write_text("t,pos\n" + "\n".join(rows))
        read_table(tmp_path / "a.csv")


@pytest.mark.slow
def test_words_that_begin_late_in_a_long_file_are_all_kept():
    rows = [f"{k},1" for k in range(21_000)] + [f"{k},broken tool" for k in range(60_000)]
    words = table_of("t,phase\n" + "\n".join(rows), "x").texts["phase"]
    assert words[:21_000] == ["1"] * 21_000 and set(words[21_000:]) == {"broken tool"} and len(words) == 81_000


def test_a_row_of_another_length_is_named_and_a_last_one_that_was_cut_off_is_left_out():
    with pytest.raises(DataError, match="x, row 3: 2 cells where the table has 3"):
        table_of("a,b,c\n1,2,3\n4,5\n6,7,8\n9,1,2\n", "x")
    table = table_of("a,b,c\n1,2,3\n4,5,6\n7,8", "x")
    assert table.rows == 2 and table.notes == ["row 4 is cut off, as by a recorder that was stopped: it is left out"]


def test_missing_values_are_no_numbers_and_a_truth_value_is_one():
    table = table_of("t,a,b\n0,,TRUE\n1,NaN,FALSE\n2,n/a,TRUE\n3,4,FALSE\n", "x")
    np.testing.assert_array_equal(table.columns["a"], [math.nan] * 3 + [4.0])
    np.testing.assert_array_equal(table.columns["b"], [1.0, 0.0, 1.0, 0.0])


def test_names_that_are_missing_or_taken_are_made_and_said():
    table = table_of(",pos,pos\n0,1,2\n1,2,3\n", "x")
    assert list(table.columns) == ["c1", "pos", "pos (2)"] and len(table.notes) == 2


def test_other_encodings_of_spreadsheets_are_read(tmp_path):
    text = "Zeit [s];Weg [\u00b5m];Kraft [N]\n0,5;1,5;2\n1,0;2,5;3\n"
    for encoding, said in (("utf-8-sig", 0), ("utf-16", 0), ("latin-1", 1)):
        (tmp_path / "a.csv").write_bytes(text.encode(encoding))
        table = read_table(tmp_path / "a.csv")
        assert table.units["Weg [\u00b5m]"] == "\u00b5m" and len(table.notes) == said
        np.testing.assert_array_equal(table.columns["Weg [\u00b5m]"], [1.5, 2.5])


def test_lines_above_the_header_are_left_out_and_a_period_that_they_name_is_used():
    table = table_of("Recorder 5\nSample time: 0.5 ms\n\nt;x\n0;1,5\n1;2,5\n2;2,5\n", "x")
    assert list(table.columns) == ["t", "x"] and table.period == pytest.approx(5e-4)
    assert table.notes == ["2 lines above the header are left out, the first of them 'Recorder 5'"]


@pytest.mark.parametrize("text", ["", "\n\n", "# nothing\n", "hello\nworld\n", "a,b\n"])
def test_what_is_no_table_is_refused_in_a_sentence(tmp_path, text):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(DataError, match=r"a\.csv: (is empty|is no table of numbers)"):
        read_table(tmp_path / "a.csv")


def test_a_file_that_is_missing_too_large_or_no_text_is_refused(tmp_path, monkeypatch):
    with pytest.raises(DataError, match=r"none\.csv: cannot be read"):
        read_table(tmp_path / "none.csv")
    (tmp_path / "a.csv").write_bytes(b"\x7fELF\0\0\0\0")
    with pytest.raises(DataError, match="is no text"):
        read_table(tmp_path / "a.csv")
    path = written(tmp_path / "b.csv", BODY)
    monkeypatch.setattr(reading, "CELLS", 11)
    with pytest.raises(DataError, match=r"4 rows of 3 columns are .* cut it into parts"):
        read_table(path)
    monkeypatch.setenv(reading.VARIABLE, "4")
    assert read_table(path).rows == 4


FINITE = st.floats(allow_nan=False, allow_infinity=False)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(FINITE, FINITE, FINITE), min_size=2, max_size=30),
    st.sampled_from([(",", "."), (";", "."), ("\t", "."), (" ", "."), (";", ","), ("\t", ",")]),
    st.booleans(),
)
def test_every_number_comes_back_to_the_bit(rows, form, headed):
    delimiter, decimal = form
    lines = [delimiter.join(repr(x).replace(".", decimal) for x in row) for row in rows]
    table = table_of("\n".join((["alpha" + delimiter + "beta" + delimiter + "gamma"] if headed else []) + lines), "x")
    np.testing.assert_array_equal(np.column_stack(list(table.columns.values())), rows)


@pytest.mark.slow
def test_the_work_on_a_long_log_grows_with_its_length():
    took = []
    for count in (1_000, 60_000):
        rows = np.random.default_rng(1).normal(size=(count, 5))
        text = "\n".join(",".join(f"{x:.9g}" for x in row) for row in rows)
        start = clock.process_time()
        table = table_of("a,b,c,d,e\n" + text, "x")
        took.append(clock.process_time() - start)
    assert took[1] < 600.0 * took[0]  # its square: 3,600
    np.testing.assert_allclose(np.column_stack(list(table.columns.values())), rows, rtol=1e-8)


@pytest.mark.parametrize("none", ["nan", "NaN", "", "NA", "-nan"])
@pytest.mark.parametrize("between", [",", ";", " "])
@pytest.mark.parametrize("head", [["t", "a", "b", "c"], None])
def test_first_rows_of_missing_values_are_rows_and_no_header(none, between, head):
    if between == " " and not none:  # white space has no empty cells
        return
    rows = [[str(k), *([none] * 3)] for k in range(5)] + [[str(k), "1.5", "2.5", "3.5"] for k in range(5, 25)]
    table = table_of("\n".join(between.join(r) for r in ([head] if head else []) + rows), "x")
    assert list(table.columns) == (head or ["c1", "c2", "c3", "c4"])
    first, second = list(table.columns.values())[:2]
    assert first.tolist() == list(range(25)) and np.isnan(second).tolist() == [True] * 5 + [False] * 20


@pytest.mark.parametrize(
    ("text", "columns"),
    [
        ("1,5\n2,5\n", [[1.5, 2.5]]),
        ("x\n1,5\n2,7\n", [[1.5, 2.7]]),
        ("0,125\n0,025\n-0,5\n", [[0.125, 0.025, -0.5]]),
        ("1,5\n2\n2,5\n", [[1.5, 2.0, 2.5]]),
        ("a,b\n1,5\n2,7\n", [[1.0, 2.0], [5.0, 7.0]]),
        ("1,-5\n2,7\n", [[1.0, 2.0], [-5.0, 7.0]]),
        ("1,7\n2,10\n", [[1.0, 2.0], [7.0, 10.0]]),
        ("".join(f"{k},{k % 7}\n" for k in range(30)), [list(range(30)), [k % 7 for k in range(30)]]),
    ],
)
def test_one_column_of_decimal_commas_is_not_split_into_two_columns_of_whole_numbers(text, columns):
    assert [c.tolist() for c in table_of(text, "x").columns.values()] == columns


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "1,5\n2,7\n",
            "'1,5' may be one number with a decimal comma or two whole numbers: write a header line with one",
        ),
        (
            "t,x\n0,001,1,5\n0,002,1,7\n",
            "the header 't,x' has 2 names, the rows have 4 cells; decimal commas need semi",
        ),
    ],
)
def test_a_comma_that_may_be_a_decimal_sign_or_a_separator_is_asked_about(text, says):
    with pytest.raises(DataError, match=says):
        table_of(text, "x")


def test_an_empty_line_among_the_values_of_one_column_is_a_missing_sample_and_shifts_no_later_one():
    table = table_of("x [mm]\n\n1.5\n2.5\n\n\n4.5\n\n\n", "x")
    np.testing.assert_array_equal(table.columns["x [mm]"], [1.5, 2.5, math.nan, math.nan, 4.5])
    np.testing.assert_array_equal(table.file_rows, [3, 4, 5, 6, 7])
    assert table_of("1.5\r\r\n2.5\r\r\n", "x").rows == 2


def test_an_empty_line_between_rows_without_times_is_refused_not_skipped(tmp_path):
    rows = [f"{math.sin(k / 50):.4f},{math.cos(k / 50):.4f}" for k in range(400)]
    rows[200:200] = [""]
    (tmp_path / "a.csv").write_text("drive,pos\n" + "\n".join(rows) + "\n\n\n")
    with pytest.raises(DataError, match="the line above row 203 is empty, and times are counted by rows: delete"):
        read_axis_log(tmp_path / "a.csv", period=1e-3)
    timed = "\n\n".join(f"{k / 1000},{row}" for k, row in enumerate(r for r in rows if r))
    (tmp_path / "b.csv").write_text("time,drive,pos\n" + timed)
    assert len(read_axis_log(tmp_path / "b.csv").time) == 400
