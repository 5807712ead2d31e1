"""No bytes make a reader fail with anything but a sentence; tests/fuzz changes whole files."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from leadscrew.logs import look_at, read_table
from leadscrew.logs.text import table_of
from leadscrew.util.errors import LeadscrewError


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fuzz")
    rows = np.arange(200.0)
    savemat(folder / "a.mat", {"t": rows, "s": {"pos": rows**2}, "u": np.sin(rows)})
    return folder


def tried(path):
    """Reads it as a table and as a log of an axis."""
    try:
        table = read_table(path)
        look_at(path, table=table)
    except LeadscrewError as refused:
        assert str(refused) and "\n" not in str(refused)


BYTES = settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def test_a_matlab_file_that_crashes_scipy_is_refused(whole, tmp_path):
    data = bytearray((whole / "a.mat").read_bytes())
    at = data.index(b"\x01\0\x01\0t\0\0\0") + 8  # Behind the name "t": the type of its values, 9 for doubles.
    assert data[at] in (2, 4, 9)
    data[at] = 255
    (tmp_path / "x.mat").write_bytes(bytes(data))
    with pytest.raises(LeadscrewError, match=r"x.mat: is broken so that its reader crashes"):
        read_table(tmp_path / "x.mat")


def test_a_parquet_file_whose_names_are_no_text_is_refused(tmp_path):
    pq.write_table(pa.table({"position": np.arange(5.0)}), tmp_path / "a.parquet", store_schema=False)
    whole = (tmp_path / "a.parquet").read_bytes()
    (tmp_path / "x.parquet").write_bytes(whole.replace(b"position", b"pos\xff\xfeion"))
    with pytest.raises(LeadscrewError, match=r"x.parquet: cannot be read"):
        read_table(tmp_path / "x.parquet")


@settings(max_examples=100, deadline=None)
@given(st.text(st.sampled_from('0123456789.,;\t|" \n\r-+eEnaN#%ab[]_\u00b5\0'), max_size=120))
def test_any_text_is_a_table_or_refused(text):
    try:
        table = table_of(text, "x")
    except LeadscrewError as refused:
        assert str(refused).startswith("x")
    else:
        assert table.rows > 0 and {len(v) for v in table.columns.values()} <= {table.rows}


@settings(BYTES, max_examples=25)
@given(data=st.binary(max_size=300))
def test_any_bytes_are_read_or_refused(tmp_path, data):
    for name in ("x.csv", "x.parquet"):
        (tmp_path / name).write_bytes(data)
        tried(tmp_path / name)
