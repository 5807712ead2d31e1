"""A perfect sensor: ``feedback = actual``."""

from __future__ import annotations

from leadscrew.kernel.block import sensor


@sensor()
def ideal(actual):
    """What the plant shows, unchanged."""
    return actual
