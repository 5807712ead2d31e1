"""Functions put into a running thread of HAL, and taken out, in the pause between two of its periods.

HAL does that without stopping the thread and without asking where it is. One that is just then inside the function that
is taken out goes on in a freed entry: the real-time process ends with a segmentation fault, and the machine with it.
With LinuxCNC 2.9 on an ordinary kernel under load that took about 1,000 removals; with the pause, 25,000 did nothing.
"""

import contextlib
import ctypes
import errno
import os
import time
from pathlib import Path

SEEN_S = 30e-6
"""From the end of a period to when the thread sleeps."""
LATE_S = 150e-6
"""From the end of a period after which the next pause is waited for; at most a third of a period."""
PATIENCE_S = 10.0


class NoPause(Exception):
    """No pause was found."""


def sleepers():
    """Handles of the states of HAL's real-time threads; none where the system does not show them."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if not (process / "comm").read_text().startswith("rtapi_app"):
                continue
            for task in (process / "task").iterdir():
                if ":T#" in (task / "comm").read_text():
                    found.append(os.open(task / "stat", os.O_RDONLY))
    return found


def asleep(handles):
    """Whether all of the threads sleep."""
    with contextlib.suppress(OSError):
        return all(x[x.rindex(b")") + 2 :][:1] in b"SZX" for x in (os.pread(h, 300, 0) for h in handles))
    return True


def in_pause(hal, thread, period, act):
    """What ``act`` gives, called while the thread sleeps between two periods, or does not run at all.

    Raises:
        NoPause: the thread never sleeps long enough.
    """
    handles, get, now = sleepers(), hal.get_value, time.monotonic
    late, still = min(LATE_S, period / 3.0), max(0.1, 20 * period)
    until = now() + PATIENCE_S
    try:
        while now() < until:
            last, began = get(f"{thread}.time"), now()
            while get(f"{thread}.time") == last and now() - began < still:
                pass
            seen = now()
            while now() - seen < min(SEEN_S, late / 2.0):
                pass
            if asleep(handles) and now() - seen < late:
                return act()
    finally:
        for handle in handles:
            os.close(handle)
    raise NoPause


def library():
    """HAL's own library, which the module hal has loaded: a call takes a microsecond, halcmd a thousand."""
    return ctypes.CDLL("liblinuxcnchal.so.0")


def into_thread(name, thread, period):
    """Puts a function at the end of a thread.

    Raises:
        OSError, NoPause: HAL refuses it, or no pause was found.
    """
    import hal

    add, words = library().hal_add_funct_to_thread, (name.encode(), thread.encode(), -1)
    code = in_pause(hal, thread, period, lambda: add(*words))
    if code:
        raise OSError(-code, f"HAL does not take {name} into {thread}: {os.strerror(-code)}")


def out_of_thread(name, thread, period):
    """Takes a function out of a thread; False: it is still there. It should be idle by now."""
    import hal

    take, words = library().hal_del_funct_from_thread, (name.encode(), thread.encode())
    try:
        code = in_pause(hal, thread, period, lambda: take(*words))
    except (NoPause, RuntimeError, OSError):
        return False
    time.sleep(max(0.02, 5 * period))
    return code in (0, -errno.EINVAL)
