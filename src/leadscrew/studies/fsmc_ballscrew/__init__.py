"""Sliding-mode control of a ball-screw stage with LuGre friction and backlash, judged by the double ball bar."""
