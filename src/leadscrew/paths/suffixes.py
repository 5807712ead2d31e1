"""Suffixes of the files that hold paths; without imports, so that a command may ask at no cost."""

GCODE = (".ngc", ".nc", ".gcode", ".tap", ".cnc")
SUFFIXES = (".svg", ".dxf", *GCODE)
