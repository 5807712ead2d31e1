"""Shared set-up: a compile cache of the tests' own, examples that are the same in CI, groups for xdist."""

import os
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import settings

# Kept from one session to the next: what is in it is named by its source and by that of the compiler.
os.environ.setdefault("LEADSCREW_CACHE_DIR", str(Path(__file__).parents[1] / "build" / "tests_cache"))

# In CI the same examples every time: a search for new ones belongs to a developer's run, who can act on what it finds.
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")

SMALL = 12
"""Slow tests of a file that is not worth dividing."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """With ``--dist loadgroup`` the slow tests of a small file run in one worker: what they share is made once."""
    slow = [item for item in items if item.get_closest_marker("slow")]
    counts = Counter(item.path for item in slow)
    for item in slow:
        if counts[item.path] <= SMALL and item.get_closest_marker("xdist_group") is None:
            item.add_marker(pytest.mark.xdist_group(item.path.stem))
