"""fuzzylite 6 as a second opinion: a program of our own that uses it, built once a session, run as its own process."""

import subprocess

import numpy as np

from leadscrew.bench import fuzzy
from tests.tools import missing

LETTERS = {"fll": "S", "fis": "I", "fcl": "C"}
"""What the driver calls the formats."""


def program() -> str:
    """The driver, compiled; skips where fuzzylite or a compiler is missing."""
    try:
        return fuzzy.fuzzylite_program()
    except fuzzy.Missing as why:
        missing("fuzzylite", str(why))


class Refused(Exception):
    """fuzzylite does not take a system or a point."""


class Fuzzylite:
    """One driver process; use it as a context."""

    def __enter__(self):
        self.process = subprocess.Popen([program()], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.wait(timeout=10)
        self.process.stdout.close()

    def _say(self, text: str) -> None:
        self.process.stdin.write(text)
        self.process.stdin.flush()

    def _line(self) -> str:
        line = self.process.stdout.readline().rstrip("\n")
        if line.startswith("error") or not line:
            raise Refused(line)
        return line

    def load(self, text: str, format: str = "fll") -> None:
        """Takes a system as text (ASCII) in one of fuzzylite's formats: fll, fis, fcl."""
        self._say(f"{LETTERS[format]} {len(text)}\n{text}")
        self._line()

    def restart(self) -> None:
        """Forgets the last outputs."""
        self._say("R\n")
        self._line()

    def evaluate(self, rows) -> np.ndarray:
        """Outputs, one row a point."""
        rows = np.asarray(rows, dtype=float)
        lines = "\n".join(" ".join(repr(float(x)) for x in row) for row in rows)
        self._say(f"P {len(rows)}\n{lines}\n")
        found = []
        for _ in rows:
            found.append([float(x) for x in self._line().split()])
        return np.array(found)

    def nanoseconds(self, rows) -> float:
        """Processor time of one evaluation, the best of five passes over the points."""
        rows = np.asarray(rows, dtype=float)
        lines = "\n".join(" ".join(repr(float(x)) for x in row) for row in rows)
        self._say(f"T {len(rows)}\n{lines}\n")
        return float(self._line())
