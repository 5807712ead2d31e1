"""Shared set-up: a compile cache of its own for each test session, shared by its workers."""

import atexit
import os
import shutil
import tempfile

from hypothesis import settings

if "LEADSCREW_CACHE_DIR" not in os.environ:
    _folder = tempfile.mkdtemp(prefix="leadscrew-tests-")
    os.environ["LEADSCREW_CACHE_DIR"] = _folder
    atexit.register(shutil.rmtree, _folder, ignore_errors=True)

# In CI the same examples every time: a search for new ones belongs to a developer's run, who can act on what it finds.
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")
