"""A sample of the random programs; ``make differential`` runs as many as one likes."""

import shutil

import pytest

from tests.kernel.differential import differences
from tests.tools import missing


def test_random_programs_give_in_machine_code_the_bits_of_plain_python(tmp_path):
    assert differences(0, 4, tmp_path, levels=(), engines=("llvm",)) == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 9))
def test_random_programs_give_the_same_bits_on_every_engine_and_as_exported(seed, tmp_path):
    if shutil.which("gcc") is None:
        missing("gcc", "gcc is not installed")
    assert differences(seed, 10, tmp_path) == []
