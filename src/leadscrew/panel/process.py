"""How the machine's process begins: what the server has to know of it, without anything heavy."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from multiprocessing import parent_process
from multiprocessing.connection import Connection, wait
from typing import Any

END_S = 2.0
"""How long the end may take after the server's."""


@dataclass(frozen=True)
class Spec:
    """What the process is to drive."""

    folder: str
    study: str = ""
    controller: str = ""
    scenario: str = ""
    hal: str = ""
    """A file that says what to attach to; empty for a simulated machine."""
    run: int = 0
    """Number of the last run of a process before this one."""
    changes: Mapping[str, Any] | None = None
    seed: int | None = None
    circle: bool = False
    named: tuple[str, ...] = ()
    """Studies that the command line named, beside the catalogue's."""
    own: tuple[str, ...] = ()
    """Controllers that it named, beside the study's."""
    trust: bool = False
    """Python that a file names runs wherever it lies: the command line said ``--trust``."""


def main(connection: Connection, spec: Spec) -> None:
    """The process. Ctrl-C is the server's to act on; a signal to end, which a service manager sends to both, is obeyed
    in order.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    from leadscrew.panel.worker import Gone, Worker
    from leadscrew.userfile import trust

    code = 1
    try:
        worker = Worker(connection, spec)
        signal.signal(signal.SIGTERM, lambda *_: worker.end())
        with trust() if spec.trust else nullcontext():
            worker.run()
    except Gone:
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(code)


def _end_with_parent() -> None:
    """A server that was killed takes the machine with it, also out of a long computation; first it may end by itself,
    so that a real machine is left as it is safe and the session is kept.
    """
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        time.sleep(END_S)
        os._exit(1)


__all__ = ["Spec", "main"]
