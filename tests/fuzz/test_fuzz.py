"""Broken and hostile files before every reader: read, or refused in a sentence. ``python -m tests.fuzz`` tries more."""

import pytest

from tests.budget import WHOLE
from tests.fuzz.one import made, tried
from tests.fuzz.targets import targets

BY_NAME = pytest.mark.parametrize("target", targets(), ids=lambda t: t.name.replace(" ", "-"))


FOUND = [("dxf", 10040), ("dxf", 10075), ("dxf", 10476), ("identify friction", 10141)]
"""Readers and numbers of files that ended with a traceback once."""


@BY_NAME
def test_a_changed_file_is_read_or_refused_in_a_sentence(target, tmp_path):
    several(target, tmp_path, 0, 1)


@pytest.mark.slow
@BY_NAME
def test_many_changed_files_are_read_or_refused_in_a_sentence(target, tmp_path):
    several(target, tmp_path, 1, (300 if WHOLE else 12) * target.weight)


@pytest.mark.parametrize(("name", "seed"), FOUND)
def test_files_that_were_found_this_way_are_refused(name, seed, tmp_path):
    several(next(t for t in targets() if t.name == name), tmp_path, seed, 1)


def several(target, folder, first, count):
    for seed in range(first, first + count):
        place = folder / str(seed)
        place.mkdir()
        assert tried(target, made(target, seed, place)) in ("read", "refused"), f"{target.name} {seed}"
