#!/usr/bin/python3
"""Stands in for LinuxCNC's screen: homes the machine, runs three moves, writes down where the axis was."""

import json
import time
from pathlib import Path

import linuxcnc
from screen import command, homed, off, status

MOVES = ("G21 G90 G1 X20 F1200", "G1 X-15 Y5", "G0 X3.5 Y0")


seen, largest, travel = [], 0.0, [0.0, 0.0]
at_home = homed()
for line in MOVES:
    command.mdi(line)
    end = time.monotonic() + 20
    while time.monotonic() < end:
        status.poll()
        x = status.joint_actual_position[0]
        largest = max(largest, abs(status.joint[0]["ferror_current"]))
        travel = [min(travel[0], x), max(travel[1], x)]
        if status.interp_state == linuxcnc.INTERP_IDLE and status.inpos and abs(x - status.joint_position[0]) < 1e-6:
            break
        time.sleep(0.002)
    seen.append([status.joint_position[0], status.joint_actual_position[0]])
enabled = bool(status.enabled)
found = {
    "homed": at_home,
    "enabled": enabled,
    "ends": seen,
    "travel": travel,
    "largest following error": largest,
    "errors": off(),
}
Path("found.json").write_text(json.dumps(found), encoding="utf-8")
