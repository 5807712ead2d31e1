"""Shared set-up: a compile cache of its own for each test session, shared by its workers."""

import atexit
import os
import shutil
import tempfile

if "LEADSCREW_CACHE_DIR" not in os.environ:
    _folder = tempfile.mkdtemp(prefix="leadscrew-tests-")
    os.environ["LEADSCREW_CACHE_DIR"] = _folder
    atexit.register(shutil.rmtree, _folder, ignore_errors=True)
