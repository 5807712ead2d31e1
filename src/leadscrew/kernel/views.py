"""Views of a loop and of a run that higher layers compute and draw.

The kernel imports no layer above it, and yet ``loop.margins()`` and ``run.plot()`` belong to its objects. So the
package ``leadscrew``, which stands above all layers, fills this table when it is imported: ``module:function`` by the
name of the view. A view is imported when it is first used.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

HOMES: dict[str, str] = {}


def view(name: str) -> Callable[..., Any]:
    """The function that computes or draws this view."""
    module, function = HOMES[name].split(":")
    return getattr(import_module(module), function)
