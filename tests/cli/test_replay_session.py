"""``leadscrew replay SESSION.toml``: what was done at the panel, again."""

from dataclasses import replace

import pyarrow.parquet as pq
import pytest

from leadscrew import __version__
from leadscrew.operate import session_file
from leadscrew.operate.operated import Operated, Start
from tests.cli.conftest import strict_json
from tests.cli.test_simulate import REMOVED
from tests.operate.bench_study import NAME


@pytest.fixture(scope="module")
def session():
    """A session of three changes."""
    operated = Operated(Start(NAME, "pid", "way"))
    operated.advance(30)
    operated.set({"controller.kp": 4.0})
    operated.advance(20)
    operated.switch("gain")
    operated.advance(50)
    return operated.session()


def test_a_session_is_replayed_bit_for_bit(call, session, tmp_path):
    path = tmp_path / "s.toml"
    session_file.write(session, path)
    assert call("replay", path).stdout.startswith("identical: 100 rows of ")
    said = call("replay", path, "--out", tmp_path / "out").stdout
    assert f"{tmp_path / 'out'}: signals.parquet and session.toml" in said
    table = pq.read_table(tmp_path / "out" / "signals.parquet")
    assert table.num_rows == 100 and "plant.speed" in table.column_names
    assert session_file.read(tmp_path / "out" / "session.toml") == session


def test_a_changed_session_is_not_identical(call, session, tmp_path):
    path = tmp_path / "s.toml"
    first, second = session.events
    session_file.write(replace(session, events=(replace(first, changes={"controller.kp": 4.5}), second)), path)
    path.write_text(path.read_text().replace(f'leadscrew = "{__version__}"', 'leadscrew = "0.0.9"'))
    assert call("replay", path, code=1).stdout == (
        "not identical: the signals differ first between t = 0.03 s and 0.05 s\n"
        f"the session was written by Leadscrew 0.0.9 and replayed by Leadscrew {__version__}\n"
    )
    found = strict_json(call("replay", path, "--json", code=1).stdout)
    assert not found["identical"] and found["rows"] == 100 and found["events"] == 2
    assert "0.03 s" in found["first_difference"]
    assert (found["written_by"], found["replayed_by"]) == ("0.0.9", __version__)


def test_a_session_on_the_removed_engine_is_replayed_on_llvm(call, session, tmp_path):
    path = tmp_path / "s.toml"
    session_file.write(replace(session, start=replace(session.start, engine="numba")), path)
    result = call("replay", path)
    assert result.stdout.startswith("identical: 100 rows of ") and result.stderr == REMOVED
    with pytest.warns(UserWarning, match="'numba': this engine was removed"):
        assert session_file.read(path).start.engine == "llvm"


def test_what_is_no_session_is_refused(refused, session, tmp_path, study):
    other = tmp_path / "machine.toml"
    other.write_text('kind = "machine"\n', encoding="utf-8")
    assert "is not a session: its kind is 'machine'" in refused("replay", other)
    assert "there is no file" in refused("replay", tmp_path / "none.toml")
    path = tmp_path / "s.toml"
    session_file.write(replace(session, start=replace(session.start, controller="pdi")), path)
    assert "did you mean pid" in refused("replay", path)
    session_file.write(session, path)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "a").touch()
    assert "exists already" in refused("replay", path, "--out", tmp_path / "full")
    assert "is for sessions" in refused("replay", tmp_path, "--out", tmp_path / "o")
