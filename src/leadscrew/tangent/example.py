"""An example drawing: nested transforms, Bezier curves, the arc of an ellipse, corners, and a rounded rectangle."""

from __future__ import annotations

from pathlib import Path

FILE = Path(__file__).with_name("example.svg")
"""200 mm x 120 mm."""
