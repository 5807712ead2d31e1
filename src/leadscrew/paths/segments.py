"""The segments of a path: line, circular arc, elliptic arc, Bezier curve, B-spline (NURBS).

Each has exact derivatives; length, its inverse, tangent and curvature follow in :mod:`leadscrew.paths.curve`, for line
and arc in closed form. The curves are in :mod:`leadscrew.paths.arcs` and :mod:`leadscrew.paths.splines`.
"""

from leadscrew.paths.arcs import Arc, EllipseArc, Line
from leadscrew.paths.splines import Bezier, Spline

__all__ = ["Arc", "Bezier", "EllipseArc", "Line", "Spline"]
