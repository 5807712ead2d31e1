#!/usr/bin/python3
"""Stands in for LinuxCNC's screen: homes the machine, runs three moves, writes down where the axis was."""

import json
import time
from pathlib import Path

import linuxcnc

MOVES = ("G21 G90 G1 X20 F1200", "G1 X-15 Y5", "G0 X3.5 Y0")


def waited(condition, seconds=20.0):
    """Whether a condition came true in time."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        status.poll()
        if condition():
            return True
        time.sleep(0.01)
    return False


def connected():
    """LinuxCNC's channels for commands, status and errors, once they are open."""
    for _ in range(200):
        try:
            now = linuxcnc.stat()
            now.poll()
            return linuxcnc.command(), now, linuxcnc.error_channel()
        except linuxcnc.error:
            time.sleep(0.05)
    raise SystemExit("LinuxCNC did not come up")


command, status, errors = connected()
seen, largest, travel = [], 0.0, [0.0, 0.0]
command.state(linuxcnc.STATE_ESTOP_RESET)
command.wait_complete(5)
command.state(linuxcnc.STATE_ON)
command.wait_complete(5)
waited(lambda: status.enabled)
command.mode(linuxcnc.MODE_MANUAL)
command.wait_complete(5)
command.teleop_enable(0)
command.wait_complete(5)
command.home(-1)
homed = waited(lambda: sum(status.homed[:3]) == 3)
command.mode(linuxcnc.MODE_MDI)
command.wait_complete(5)
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
command.state(linuxcnc.STATE_OFF)
command.wait_complete(5)
told = []
while message := errors.poll():
    told.append(message[1])
found = {
    "homed": homed,
    "enabled": enabled,
    "ends": seen,
    "travel": travel,
    "largest following error": largest,
    "errors": told,
}
Path("found.json").write_text(json.dumps(found), encoding="utf-8")
