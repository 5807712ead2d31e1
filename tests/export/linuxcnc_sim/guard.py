#!/usr/bin/python3
"""Stands in for LinuxCNC's screen: moves of every kind, a force that rises in each, and what the axes do."""

import json
import math
from pathlib import Path

import hal
import linuxcnc
from screen import command, homed, off, status, waited

RAPID = 1
"""``motion.motion-type`` on a traverse."""

cell = hal.component("cell")
cell.newpin("force", hal.HAL_FLOAT, hal.HAL_OUT)
cell["force"] = 100.0
cell.ready()
hal.connect("cell.force", "load-cell")


def clock():
    """Time of the servo thread, s: on a busy machine it runs behind that of the wall and catches up."""
    return hal.get_value("servo-clock.out")


def slept(seconds):
    """Lets the servo thread run for a while."""
    end = clock() + seconds
    assert waited(lambda: clock() >= end)


def place():
    """Where the axes are commanded."""
    return [hal.get_value(f"joint.{n}.pos-cmd") for n in (0, 1, 2)]


def seen_at():
    """Where the axes are commanded, and when: read within one period of the servo thread."""
    while True:
        t, at = clock(), place()
        if clock() == t:
            return at, t


def at_rest():
    """Whether the program line is done."""
    status.poll()
    return status.interp_state == linuxcnc.INTERP_IDLE and status.inpos


def speed(seconds=0.1):
    """Speed of the axes over a while, mm/s."""
    a, began = seen_at()
    slept(seconds)
    b, ended = seen_at()
    return math.dist(a, b) / (ended - began)


def climbed():
    """Lets the controller climb to the programmed feed, at a force below the one to hold; on a rapid it gives 1."""
    cell["force"] = 100.0
    over = waited(lambda: hal.get_value("motion.motion-type") != RAPID)
    slept(0.01)
    return over and waited(lambda: hal.get_value("force-guard.output") == 1.0)


def tried(line, force, before=0.3):
    """Speeds in a move: before a force, after it, and after it has gone; whether the move was done in the end."""
    ready = climbed()
    command.mdi(line)
    slept(before)
    found = {"ready": ready, "override": hal.get_value("force-guard.output"), "before": speed()}
    cell["force"] = force
    slept(0.15)
    found |= {
        "held": hal.get_value("force-guard.output"),
        "during": speed(0.2),
        "fault": hal.get_value("force-guard.fault-code"),
    }
    cell["force"] = 100.0
    if math.isnan(force):
        hal.set_p("force-guard.max-following-error", "0")
        command.state(linuxcnc.STATE_OFF)
        slept(0.2)
        command.state(linuxcnc.STATE_ON)
        slept(0.2)
        command.mode(linuxcnc.MODE_MDI)
        command.wait_complete(5)
    else:
        found["done"] = waited(at_rest, 30.0)
    found["where"] = place()
    return found


at_home = homed()
seen = {}
for line in ("G21 G90 M52 P1", "M68 E0 Q600", "S600 M3"):
    command.mdi(line)
    command.wait_complete(5)
seen["feed"] = waited(lambda: hal.get_value("force-guard.command-feed") == 600.0)
seen["G1"] = tried("G1 X15 F600", 250.0)
seen["G0"] = tried("G0 X-30", 250.0)
seen["G2"] = tried("G2 X-20 Y0 I5 J0 F600", 250.0)
seen["G95"] = tried("G95 G1 X-5 F1", 250.0)
command.mdi("G94")
command.wait_complete(5)
seen["G33"] = tried("G33 Z15 K1", 250.0, before=0.5)
climbed()
cell["force"] = 250.0
waited(lambda: hal.get_value("force-guard.output") == 0.0)
command.mode(linuxcnc.MODE_MANUAL)
command.wait_complete(5)
jogs = {}
for name, teleop in (("joint", 0), ("teleop", 1)):
    command.teleop_enable(teleop)
    command.wait_complete(5)
    slept(0.2)
    command.jog(linuxcnc.JOG_CONTINUOUS, 1 - teleop, 1, 5.0)
    slept(0.3)
    jogs[name] = speed(0.3)
    command.jog(linuxcnc.JOG_STOP, 1 - teleop, 1)
    slept(0.3)
seen["jogs"] = {"held": hal.get_value("force-guard.output"), **jogs}
command.mode(linuxcnc.MODE_MDI)
command.wait_complete(5)
command.mdi("M52 P0")
command.wait_complete(5)
seen["M52 P0"] = tried("G1 X10 F600", 250.0)
command.mdi("M52 P1")
command.wait_complete(5)
seen["not a number"] = tried("G1 X-5 F600", math.nan)
Path("found.json").write_text(json.dumps({"homed": at_home, "seen": seen, "errors": off()}), encoding="utf-8")
