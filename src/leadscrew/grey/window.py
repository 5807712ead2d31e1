"""The rolling window: the newest five samples of a signal, oldest first, and how many of them are real."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.parameters import Doc

LENGTH = 5
"""Samples that a window holds."""


class Window(NamedTuple):
    """Five samples of one signal at equal distance in time; what has not come yet is 0."""

    y0: Annotated[float, Doc("oldest")] = 0.0
    y1: float = 0.0
    y2: float = 0.0
    y3: float = 0.0
    y4: Annotated[float, Doc("newest")] = 0.0
    count: Annotated[int, Doc("samples seen so far, at most five")] = 0  # type: ignore[assignment]


def pushed(window, y):
    """The window after one more sample."""
    return Window(window.y1, window.y2, window.y3, window.y4, y, min(window.count + 1, LENGTH))


def filled(y):
    """A window that has seen nothing but ``y``: the start of a controller that takes over while the process runs."""
    return Window(y, y, y, y, y, LENGTH)


def lifted(window, by):
    """All samples of the window raised by a number."""
    return Window(
        window.y0 + by, window.y1 + by, window.y2 + by, window.y3 + by, window.y4 + by, window.count
    )  # fmt: skip
