"""Plane paths with exact tangent and curvature: what a tangential axis follows, and the files they are read from."""
