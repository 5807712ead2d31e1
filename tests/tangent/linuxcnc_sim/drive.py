#!/usr/bin/python3
"""Stands in for LinuxCNC's screen: homes the cutter, runs the programs in turn, and writes down where its axes were."""

import json
import time
from pathlib import Path

import linuxcnc
from screen import command, homed, off, status, waited

at_home = homed() and bool(waited(lambda: status.homed[3]))
found = {"homed": at_home, "runs": {}}
for file in sorted(Path().glob("*.ngc")):
    command.mode(linuxcnc.MODE_AUTO)
    command.wait_complete(5)
    command.program_open(str(file.resolve()))
    command.wait_complete(5)
    command.auto(linuxcnc.AUTO_RUN, 0)
    begun, rows = time.monotonic(), []
    waited(lambda: status.interp_state != linuxcnc.INTERP_IDLE, 2.0)
    while time.monotonic() < begun + 60.0:
        status.poll()
        rows.append([time.monotonic() - begun, *status.joint_position[:4], status.current_vel])
        if status.interp_state == linuxcnc.INTERP_IDLE and status.inpos and not status.queue:
            break
        time.sleep(0.001)
    found["runs"][file.stem] = rows
found["errors"] = off()
Path("found.json").write_text(json.dumps(found), encoding="utf-8")
