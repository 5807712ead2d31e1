"""The same loops hand-written in C: compiled into the cache, called through ctypes."""

from __future__ import annotations

import ctypes
import hashlib
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.bench.loops import SUBSTEPS
from leadscrew.kernel import cache
from leadscrew.plants._lathe_servo import LatheServoParams, lathe_servo_hold

FLAGS = ("-std=c99", "-O3", "-march=native", "-ffp-contract=off", "-fPIC", "-shared")
SOURCES = Path(__file__).parent / "c"
LOOPS = tuple(f"{form}_{power}" for form in ("hold", "rk4") for power in ("portable", "shortcut", "libm"))


class NoCompilerError(Exception):
    """The yardstick cannot be built here; says why."""


class Lathe(ctypes.Structure):
    """Mirrors ``Lathe`` of ``lathe.h``."""

    _fields_ = tuple(
        [(name, ctypes.c_double) for name in ("target", "resolution", "error_scale", "rate_scale", "rate_interval")]
        + [(name, ctypes.c_double) for name in ("tau", "floor", "output_tau", "output_gain")]
        + [(name, ctypes.c_double * n) for name, n in (("centres", 6), ("reciprocal_widths", 5), ("rules", 36))]
        + [("full_duty_speed", ctypes.c_double), ("a", ctypes.c_double * 14), ("b", ctypes.c_double * 5)]
        + [(f"{name}_lag", ctypes.c_double) for name in ("pwm", "electrical", "mechanical", "grating")]
        + [(name, ctypes.c_double) for name in ("period", "substeps", "bound")]
    )


AXIS = ("pwm", "current", "speed", "position", "reading")


class Motion(ctypes.Structure):
    """Mirrors ``Motion`` of ``lathe.h``."""

    _fields_ = tuple(
        (name, ctypes.c_double) for name in ("e", "started", "rho", *AXIS, "squares", "absolutes", "time", "largest")
    )


def compiler() -> str:
    """The path of gcc.

    Raises:
        NoCompilerError: there is none.
    """
    found = shutil.which("gcc")
    if found is None:
        raise NoCompilerError("no gcc on the path")
    return found


def build(source: str = "lathe.c") -> ctypes.CDLL:
    """A compiled yardstick, from the cache where its sources, flags and compiler are the same.

    Raises:
        NoCompilerError: no gcc, or it fails.
    """
    gcc = compiler()
    version = subprocess.run([gcc, "-dumpfullversion"], capture_output=True, text=True, check=False).stdout
    sources = (path for path in sorted(SOURCES.iterdir()) if path.suffix in (".c", ".h"))
    text = "".join(path.read_text(encoding="utf-8") for path in sources)
    name = hashlib.sha256(f"{version} {FLAGS} {source} {text}".encode()).hexdigest()[:20]
    library = f"yardstick_{name}.so"
    if cache.read(library) is not None:
        return ctypes.CDLL(str(cache.directory() / library))
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        made = Path(folder) / library
        command = [gcc, *FLAGS, str(SOURCES / source), "-o", str(made), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise NoCompilerError(f"gcc failed: {done.stderr.strip()[:200]}")
        kept = cache.write(library, made.read_bytes())
        return ctypes.CDLL(str(cache.directory() / library if kept else made))


class Yardstick:
    """The C loops with the parameters of one of ours."""

    def __init__(self, loop: Any) -> None:
        self.library = build()
        self.params = self.parameters(loop)
        for name in LOOPS:
            function = getattr(self.library, name)
            function.argtypes = [ctypes.POINTER(Lathe), ctypes.POINTER(Motion), ctypes.c_long]
            function.restype = ctypes.c_long

    @staticmethod
    def parameters(loop: Any) -> Lathe:
        """The loop's parameters by their C names."""
        given = {k.removeprefix("controller."): v for k, v in loop.parameters.items()}
        axis = LatheServoParams(*(loop.parameters[f"plant.{f}"] for f in LatheServoParams._fields))
        hold = lathe_servo_hold(axis, loop.period)
        centres = np.asarray(given["e_centres"])
        p = Lathe(
            target=loop.parameters["reference.target"],
            resolution=loop.parameters["sensor.resolution_mm"],
            error_scale=given["error_full_scale_mm"],
            rate_scale=given["rate_full_scale_mm"],
            rate_interval=given["rate_interval_s"],
            tau=given["tau"],
            floor=given["floor"],
            output_tau=given["output_tau"],
            output_gain=given["output_gain"],
            full_duty_speed=axis.full_duty_speed_mm_s,
            pwm_lag=axis.pwm_lag_s,
            electrical_lag=axis.electrical_lag_s,
            mechanical_lag=axis.mechanical_lag_s,
            grating_lag=axis.grating_lag_s,
            period=loop.period,
            substeps=SUBSTEPS,
            bound=loop.bound,
        )
        rows: Iterable[tuple[Any, Any]] = (
            (p.centres, centres),
            (p.reciprocal_widths, 1.0 / np.diff(centres)),
            (p.rules, np.ravel(given["rules"])),
            (p.a, hold[1:15]),
            (p.b, hold[15:20]),
        )
        for target, values in rows:
            target[:] = [float(v) for v in values]
        return p

    @cached_property
    def start(self) -> Motion:
        """At rest at 0."""
        return Motion(largest=-1.0)

    def run(self, name: str, periods: int) -> Motion:
        """One of :data:`LOOPS` from rest.

        Raises:
            RuntimeError: it diverged.
        """
        motion = Motion()
        ctypes.pointer(motion)[0] = self.start
        if getattr(self.library, name)(self.params, motion, periods) != periods:
            raise RuntimeError(f"{name} diverged")
        return motion


def same_bits(motion: Motion, live: Any) -> bool:
    """Whether a motion of ours (a live loop) and one in C ended in the same bits, sums of the metrics included."""
    ours = live.values()
    pairs = [(getattr(motion, f), ours[f"plant.{f}"]) for f in AXIS]
    pairs += [(motion.e, ours["controller.e"]), (motion.rho, ours["controller.rho"])]
    pairs += [(motion.squares, ours["metrics.rms.total"]), (motion.absolutes, ours["metrics.iae.total"])]
    pairs += [(motion.largest, ours["metrics.max.largest"])]
    return all(np.float64(a).tobytes() == np.float64(b).tobytes() for a, b in pairs)
