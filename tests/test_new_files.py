"""Files and folders that appear whole or not at all."""

import stat

import pytest

from leadscrew.kernel.errors import DataError
from leadscrew.newfile import save
from leadscrew.newfolder import appearing


def names(folder):
    return sorted(p.name for p in folder.rglob("*"))


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.parametrize("durable", [True, False])
def test_a_file_is_saved_with_its_lines_as_given_and_replaces_an_older_one(tmp_path, durable):
    for data, expected in (("a\r\nµ\n", b"a\r\n\xc2\xb5\n"), (b"\x00\xff", b"\x00\xff")):
        save(data, tmp_path / "new" / "x.txt", durable)
        assert (tmp_path / "new" / "x.txt").read_bytes() == expected
    assert names(tmp_path) == ["new", "x.txt"] and mode(tmp_path / "new" / "x.txt") == 0o644


def test_a_file_that_cannot_be_put_in_its_place_leaves_nothing_beside_it(tmp_path):
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / "kept").write_text("")
    with pytest.raises(DataError, match="x cannot be written: Is a directory"):
        save("data", tmp_path / "x")
    with pytest.raises(DataError, match="cannot be written"):
        save("data", tmp_path / "x" / "kept" / "below")
    assert names(tmp_path) == ["kept", "x"]


def test_a_folder_appears_at_the_end_for_all_to_read(tmp_path):
    for name in ("new", "empty"):
        if name == "empty":
            (tmp_path / name).mkdir()
        with appearing(tmp_path / name) as place:
            (place / "a").write_text("1")
            assert not (tmp_path / name / "a").exists()
        assert names(tmp_path / name) == ["a"] and mode(tmp_path / name) == 0o755


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), ValueError("no"), KeyboardInterrupt()])
def test_a_folder_whose_writing_ends_early_leaves_nothing(tmp_path, error):
    with pytest.raises((DataError, type(error))) as seen, appearing(tmp_path / "out") as place:
        (place / "a").write_text("1")
        raise error
    assert names(tmp_path) == []
    if isinstance(error, OSError):
        assert "out cannot be written: No space left on device" in str(seen.value)


def test_a_folder_with_something_in_it_is_not_written_over(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "kept").write_text("1")
    for target in ("out", "out/kept"):
        with pytest.raises(DataError, match="exists already"), appearing(tmp_path / target):
            pass
    with pytest.raises(DataError, match="kept is not a folder"), appearing(tmp_path / "out" / "kept" / "below"):
        pass
    assert names(tmp_path) == ["kept", "out"]
