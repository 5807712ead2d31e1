"""Shared set-up: one cache for all workers of a test session, kept between sessions so that loops compile once."""

import os
import tempfile
from pathlib import Path

import pytest

os.environ.setdefault(
    "LEADSCREW_CACHE_DIR",
    str(Path(tempfile.gettempdir()) / f"leadscrew-tests-{os.getuid() if hasattr(os, 'getuid') else 'user'}"),
)


def pytest_configure(config: pytest.Config) -> None:
    """Registers nothing; here so that the environment above is set before any test module is imported."""
