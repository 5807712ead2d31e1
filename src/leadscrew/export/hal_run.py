"""Runs LinuxCNC's ``halrun`` apart from whatever else the machine runs.

Each run has its own IPC, process and mount namespaces: HAL's global keys do not meet those of a running LinuxCNC, the
module folder is a copy that is gone afterwards, and nothing outlives the run. That takes root, as LinuxCNC's own
install of a component does.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from leadscrew.util.errors import LeadscrewError

MODULES = Path("/usr/lib/linuxcnc/modules")
PYTHON = "/usr/bin/python3"
"""The Python that LinuxCNC's ``hal`` module is installed for."""
NOBODY = "65534"
FAKETIME = ("libfaketime.so.1", ("/usr/lib/*/faketime", "/usr/lib/faketime", "/usr/lib64/faketime"))
SEPARATE = ("unshare", "--ipc", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc")


class HalFailed(LeadscrewError):
    """HAL did not run, or the component did not compile; the text says why."""


def lacking() -> str:
    """What is missing here to run HAL, as a sentence; empty if nothing is."""
    if not sys.platform.startswith("linux"):
        return "LinuxCNC runs on Linux only"
    tools = [
        t for t in ("halrun", "halcompile", "halstreamer", "gcc", "make", "unshare", "mount") if not shutil.which(t)
    ]
    if tools:
        return f"{', '.join(tools)} not found: install linuxcnc-uspace, linuxcnc-uspace-dev, gcc and make"
    if not MODULES.is_dir():
        return f"LinuxCNC's modules are not in {MODULES}"
    if os.geteuid() != 0:
        return "installing a HAL component takes root: run this as root"
    if subprocess.run([*SEPARATE, "true"], capture_output=True, check=False).returncode:
        return "no permission to make namespaces (unshare): a container needs CAP_SYS_ADMIN for it"
    if subprocess.run([PYTHON, "-c", "import hal"], capture_output=True, check=False).returncode:
        return f"{PYTHON} has no module hal: install linuxcnc-uspace"
    return ""


def version() -> str:
    """Version of LinuxCNC."""
    asked = ["linuxcnc_var", "LINUXCNCVERSION"]
    try:
        return subprocess.run(asked, capture_output=True, text=True, check=True, timeout=20).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return "of unknown version"


def faketime() -> str:
    """Path of libfaketime, which makes HAL's threads run fast; empty if it is not there."""
    name, folders = FAKETIME
    return next((str(f) for folder in folders for f in sorted(Path("/").glob(f"{folder[1:]}/{name}"))), "")


@contextmanager
def workplace() -> Iterator[Path]:
    """A folder that HAL's processes can reach, with a private copy of LinuxCNC's modules; gone afterwards."""
    place = Path(tempfile.mkdtemp(prefix="leadscrew-hal-", dir="/tmp"))
    try:
        place.chmod(0o755)
        (place / "fifo").mkdir()
        (place / "fifo").chmod(0o777)
        shutil.copytree(MODULES, place / "modules", symlinks=True)
        yield place
    finally:
        shutil.rmtree(place, ignore_errors=True)


def install(place: Path, folder: Path, name: str, timeout: float = 120.0) -> None:
    """Compiles an exported component with halcompile and installs it among the workplace's modules.

    Raises:
        HalFailed: it does not compile, with the compiler's first error.
    """
    source = place / "source"
    source.mkdir(exist_ok=True)
    for file in folder.iterdir():
        if file.suffix in (".comp", ".c", ".h"):
            shutil.copyfile(file, source / file.name)
    if not (source / f"{name}.comp").is_file():
        raise HalFailed(f"there is no {name}.comp in {folder}: export the hal target again")
    code, output = apart(place, ["halcompile", "--install", f"{name}.comp"], timeout, source)
    if code:
        lines = output.splitlines()
        worst = next(
            (x for x in lines if "error" in x.lower()), lines[-1] if lines else f"halcompile ended with {code}"
        )
        raise HalFailed(f"halcompile {name}.comp: {worst.replace(f'{source}/', '').strip()}")


def run(place: Path, script: str, speed: int = 300, timeout: float = 60.0) -> str:
    """What a HAL script prints, run with time ``speed`` times as fast where libfaketime is installed.

    Raises:
        HalFailed: it ended with an error or did not end in time.
    """
    file = place / "run.hal"
    file.write_text(script, encoding="utf-8")
    settings = [f"RTAPI_UID={NOBODY}", f"RTAPI_FIFO_PATH={place}/fifo/rtapi"]
    library = faketime()
    if speed > 1 and library:
        settings += [f"LD_PRELOAD={library}", f"FAKETIME=+0 x{speed}"]
    code, output = apart(place, ["env", *settings, "halrun", str(file)], timeout, place)
    if code:
        told = [x for x in output.splitlines() if x.strip() and not x.startswith("Note:")]
        raise HalFailed(f"halrun ended with {code}: {told[0] if told else 'it printed nothing'}")
    return output


def apart(place: Path, command: list[str], timeout: float, folder: Path) -> tuple[int, str]:
    """Runs a command in namespaces of its own, the workplace's modules in place of LinuxCNC's."""
    first = f'mount --bind {place}/modules {MODULES} && exec "$@"'
    log = place / "log.txt"
    with log.open("w", encoding="utf-8") as out:
        try:
            done = subprocess.run(
                [*SEPARATE, "bash", "-c", first, "bash", *command],
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=subprocess.STDOUT,
                check=False,
                timeout=timeout,
                cwd=folder,
            )
        except subprocess.TimeoutExpired:
            tool = next((x for x in command if x in ("halcompile", "halrun")), command[0])
            raise HalFailed(f"{tool} was not done within {timeout:g} s") from None
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    return done.returncode, "\n".join(x for x in lines if not x.startswith("Running with fallback_uid"))
