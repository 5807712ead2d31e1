#!/usr/bin/python3
"""Stands in for LinuxCNC's screen: homes the axis, starts record.sh as a user would, and runs move.ngc."""

import json
import subprocess
import time
from pathlib import Path

import linuxcnc
from screen import command, homed, off, status, waited

at_home = homed()
recorder = subprocess.Popen(["./record.sh", "log.txt"])
command.mode(linuxcnc.MODE_AUTO)
command.wait_complete(5)
command.program_open(str(Path("move.ngc").resolve()))
command.wait_complete(5)
command.auto(linuxcnc.AUTO_RUN, 0)
begun = time.monotonic()
waited(lambda: status.interp_state != linuxcnc.INTERP_IDLE, 2.0)
while time.monotonic() < begun + 90.0:
    status.poll()
    if status.interp_state == linuxcnc.INTERP_IDLE and status.inpos and not status.queue:
        break
    time.sleep(0.01)
ran = time.monotonic() - begun
time.sleep(0.5)
recorder.terminate()
ended = recorder.wait(10)
found = {"homed": at_home, "ran": ran, "recorder": ended, "errors": off()}
Path("found.json").write_text(json.dumps(found), encoding="utf-8")
