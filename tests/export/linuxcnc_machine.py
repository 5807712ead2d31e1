"""The real LinuxCNC, headless: runs a machine's folder and gives what the script in place of its screen saw."""

import json
import shutil

from leadscrew.export import hal_run


def seen_by(machine, place, seconds=90.0):
    """What ``drive.py`` of the folder ``machine`` wrote down."""
    for path in (machine, *machine.iterdir()):
        shutil.chown(path, int(hal_run.NOBODY), int(hal_run.NOBODY))
    # LinuxCNC is not for root; its server listens on a fixed port, hence a network of its own.
    user = ["setpriv", f"--reuid={hal_run.NOBODY}", f"--regid={hal_run.NOBODY}", "--clear-groups"]
    clean = ["env", "-i", "PATH=/usr/bin:/bin", f"HOME={machine}"]
    code, printed = hal_run.apart(place, ["unshare", "--net", *user, *clean, "linuxcnc", "axis.ini"], seconds, machine)
    assert (machine / "found.json").is_file(), f"linuxcnc ended with {code}: {printed}"
    return json.loads((machine / "found.json").read_text(encoding="utf-8"))
