#!/usr/bin/python3
"""Stands in for LinuxCNC's screen: homes, goes to positions in turn, and writes down what the motor was told there."""

import json
import time
from pathlib import Path

import hal
import linuxcnc
from screen import command, homed, off, status, waited

watch = hal.component("watch")
watch.ready()
at_home = homed()
seen = []
for position in json.loads(Path("positions.json").read_text()):
    command.mdi(f"G21 G90 G0 X{position}")
    command.wait_complete(20)
    rest = waited(lambda: status.interp_state == linuxcnc.INTERP_IDLE and status.inpos)
    time.sleep(0.1)
    pins = [hal.get_value(f"joint.0.{n}") for n in ("pos-cmd", "motor-pos-cmd", "motor-offset", "pos-fb")]
    seen.append([rest, *pins])
Path("found.json").write_text(json.dumps({"homed": at_home, "seen": seen, "errors": off()}), encoding="utf-8")
