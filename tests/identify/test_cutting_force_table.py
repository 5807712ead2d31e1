"""The door for force tables: every way to write one, and one clear sentence for every way to get it wrong."""

import numpy as np
import pytest

from leadscrew.identify.cutting_force_table import read_force_table
from leadscrew.util.errors import DataError, ValueRefused

FEED, DEPTH, FORCE = [0.1, 0.2, 0.4], [1.0, 1.0, 2.0], [212.6, 371.0, 1451.2]
PLAIN = "feed,depth,force\n0.1,1.0,212.6\n0.2,1.0,371.0\n0.4,2.0,1451.2\n"


def written(tmp_path, text, name="cuts.csv"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def assert_the_cuts(table, rel=1e-12):
    for found, true in ((table.feed, FEED), (table.depth, DEPTH), (table.force, FORCE)):
        np.testing.assert_allclose(found, true, rtol=rel)


@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        "# tool 3\n\nF [N],f [mm/rev],ap [mm]\n212.6,0.1,1\n# pause\n371,0.2,1\n1451.2,0.4,2\n",
        "f (mm/rev);ap (mm);Fc (kN)\n0,1;1,0;0,2126\n0,2;1,0;0,371\n0,4;2,0;1,4512\n",
        "feed_mm_per_rev\tdepth_mm\tmain_force_n\n0,1\t1\t212,6\n0,2\t1\t371\n0,4\t2\t1451,2\n",
        'feed,depth,force\n"0,1","1,0","212,6"\n"0,2","1,0","371,0"\n"0,4","2,0","1451,2"\n',
        "Feed (um/rev),Depth of cut (um),Cutting Force (daN)\n100,1000,21.26\n200,1000,37.1\n400,2000,145.12\n",
        "feed (in/rev),depth (in),force (lbf)\n"
        + "".join(
            f"{f / 25.4!r},{a / 25.4!r},{x / 4.4482216152605!r}\n" for f, a, x in zip(FEED, DEPTH, FORCE, strict=True)
        ),
        "feed (mm/min),n (1/min),depth,force\n100,1000,1,212.6\n200,1000,1,371\n200,500,2,1451.2\n",
    ],
)
def test_the_same_cuts_are_read_however_they_are_written(tmp_path, text):
    assert_the_cuts(read_force_table(written(tmp_path, text)))


def test_parquet_is_read_by_its_suffix(tmp_path):
    pa = pytest.importorskip("pyarrow")
    import pyarrow.parquet as pq

    pq.write_table(pa.table({"ap": DEPTH, "f": FEED, "tool": ["a", "b", "c"], "Fc": FORCE}), tmp_path / "x.parquet")
    assert_the_cuts(read_force_table(tmp_path / "x.parquet"))
    pq.write_table(pa.table({"ap": DEPTH, "f": FEED, "Fc": [None, 1.0, 2.0]}), tmp_path / "y.parquet")
    with pytest.raises(DataError, match=r"row 1, column 'Fc': 'nan' is not a finite number"):
        read_force_table(tmp_path / "y.parquet")


def test_columns_and_units_can_be_told(tmp_path):
    path = written(tmp_path, "advance;cut;Fx;Fz\n100;1;78,2;212,6\n200;1;124,4;371\n400;2;500;1451,2\n")
    named = {"feed": "advance", "depth": "cut", "force": "Fz", "feed_force": "Fx"}
    table = read_force_table(path, columns=named, units={"feed": "um/rev"})
    assert_the_cuts(table)
    assert table.others["feed_force"].tolist() == [78.2, 124.4, 500.0]
    assert table.columns["feed"] == "advance (um/rev)"
    per_minute = written(tmp_path, "feed,depth,force\n100,1,212.6\n200,1,371\n400,2,1451.2\n", "b.csv")
    assert_the_cuts(read_force_table(per_minute, units={"feed": "mm/min"}, spindle_rpm=1000.0))


def test_a_cut_that_stands_twice_counts_once(tmp_path):
    table = read_force_table(written(tmp_path, PLAIN + "0.1,1.0,212.6\n0.1,1.0,212.7\n"))
    assert table.repeated == ((5, 2),) and table.rows == (2, 3, 4, 6)


REFUSED = {
    "empty": ("", "is empty; expected a header line"),
    "only comments": ("# nothing\n\n", "is empty"),
    "no rows": ("feed,depth,force\n", "has a header but no rows"),
    "one cell": ("feed depth force\n1 2 3\n", "is one cell; expected commas, semicolons or tabs"),
    "missing column": (PLAIN.replace("depth", "width"), "row 1: no column is the depth .*'width'.*--column depth="),
    "header twice": (PLAIN.replace("depth", "feed"), "the columns 'feed' and 'feed' are both the feed"),
    "two names": (PLAIN.replace("depth", "f"), "the columns 'feed' and 'f' are both the feed"),
    "negative feed": (PLAIN.replace("0.2,", "-0.2,"), r"row 3, column 'feed': -0\.2 is not above 0$"),
    "zero force": (PLAIN.replace("371.0", "0"), "row 3, column 'force': 0 is not above 0; a row without a cut"),
    "NaN": (PLAIN.replace("371.0", "nan"), "row 3, column 'force': 'nan' is not a finite number"),
    "infinite": (PLAIN.replace("371.0", "inf"), "'inf' is not a finite number"),
    "text": (PLAIN.replace("371.0", "high"), "row 3, column 'force': 'high' is not a number"),
    "blank": (PLAIN.replace("371.0", ""), "row 3, column 'force': '' is not a number"),
    "short row": (PLAIN + "0.3,1.0\n", "row 5: 2 cells where the header has 3"),
    "decimal commas between commas": ("feed,depth,force\n0,1,1,0,212,6\n", "row 2: 6 cells .* decimal commas need"),
    "comma and point": (
        PLAIN.replace(",", ";").replace("0.2;", "0,2;"),
        "a decimal comma in row 3 and a decimal point",
    ),
    "thousands": ("feed;depth;force\n0,1;1;1.212,6\n", "decimal comma in row 2 and a decimal point in row 2"),
    "unit unknown": (PLAIN.replace("depth", "depth (furlong)"), "'furlong', which is no unit of the depth; known are"),
    "metres": (
        PLAIN.replace("1.0,", "0.001,").replace("2.0,", "0.002,"),
        r"row 2: .* specific cutting force of 2\.126e\+06 N/mm2; .* give --unit depth=m;",
    ),
    "one row in metres": (PLAIN + "0.3,0.001,550\n", "row 5: .* and the other rows have 1814 to 2126"),
    "kilonewtons": ("f,ap,Fc\n0.1,1,0.2126\n0.2,1,0.371\n0.4,2,1.45\n", "give --unit force=kN"),
    "per minute": (PLAIN.replace("feed", "feed (mm/min)"), "no column says the spindle speed; .* --spindle-rpm"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_table_that_cannot_be_used_is_refused_in_one_sentence(tmp_path, name):
    text, says = REFUSED[name]
    path = written(tmp_path, text)
    with pytest.raises(DataError, match=says) as refused:
        read_force_table(path)
    assert str(refused.value).startswith(str(path)) and "\n" not in str(refused.value)


def test_files_that_are_none_are_refused(tmp_path):
    with pytest.raises(DataError, match="cannot be read"):
        read_force_table(tmp_path / "absent.csv")
    (tmp_path / "latin.csv").write_bytes("feed,depth,force\n0.1,1,2\xb5\n".encode("latin-1"))
    with pytest.raises(DataError, match="is not UTF-8"):
        read_force_table(tmp_path / "latin.csv")
    (tmp_path / "no.parquet").write_bytes(b"no")
    with pytest.raises(DataError, match="cannot be read"):
        read_force_table(tmp_path / "no.parquet")


def test_another_material_may_have_another_specific_force(tmp_path):
    soft = written(tmp_path, "feed,depth,force\n0.1,1,20\n0.2,1,38\n0.4,1,70\n")
    with pytest.raises(DataError, match=r"metals have 500 to 10000: if a unit .* --usual-kc LOW,HIGH"):
        read_force_table(soft)
    assert read_force_table(soft, usual_kc=(100.0, 10000.0)).force.tolist() == [20.0, 38.0, 70.0]


@pytest.mark.parametrize(
    ("more", "error", "says"),
    [
        ({"columns": {"feet": "feed"}}, ValueRefused, "feet = 'feed': allowed are feed, depth, force"),
        ({"columns": {"feed": "fed"}}, DataError, "the column 'fed' is missing; did you mean feed"),
        ({"units": {"depth": "N"}}, ValueRefused, "unit of depth = 'N': allowed are mm, um"),
    ],
)
def test_columns_and_units_that_are_none_are_refused(tmp_path, more, error, says):
    with pytest.raises(error, match=says):
        read_force_table(written(tmp_path, PLAIN), **more)
