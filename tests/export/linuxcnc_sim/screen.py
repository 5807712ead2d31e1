"""What stands in for LinuxCNC's screen in every test: its channels, homing, and the way out."""

import time

import linuxcnc


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


def waited(condition, seconds=20.0):
    """Whether a condition came true in time."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        status.poll()
        if condition():
            return True
        time.sleep(0.01)
    return False


def homed():
    """Whether the machine, switched on, found its home; it then takes G-code."""
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
    found = waited(lambda: sum(status.homed[:3]) == 3)
    command.mode(linuxcnc.MODE_MDI)
    command.wait_complete(5)
    return found


def off():
    """Switches the machine off; what LinuxCNC complained of."""
    command.state(linuxcnc.STATE_OFF)
    command.wait_complete(5)
    told = []
    while message := errors.poll():
        told.append(message[1])
    return told
