"""Notebooks, executed by Jupyter in a kernel of the Python that runs the tests."""

import sys
from pathlib import Path
from typing import Any

import pytest


def executed(notebook: Any, folder: Path, *, allow_errors: bool = False) -> None:
    """Runs all cells in ``folder``; what they show is in the notebook afterwards."""
    nbclient = pytest.importorskip("nbclient", reason="nbclient is missing: pip install leadscrew[dev]")
    pytest.importorskip("ipykernel", reason="ipykernel is missing: pip install leadscrew[dev]")
    from jupyter_client.kernelspec import KernelSpec
    from jupyter_client.manager import AsyncKernelManager

    class ThisPython(AsyncKernelManager):
        """Whatever kernels are installed for the user."""

        @property
        def kernel_spec(self) -> KernelSpec:
            argv = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
            return KernelSpec(argv=argv, display_name="Python", language="python")

    nbclient.NotebookClient(
        notebook, timeout=180, kernel_manager_class=ThisPython, allow_errors=allow_errors,
        resources={"metadata": {"path": str(folder)}},
    ).execute()  # fmt: skip
