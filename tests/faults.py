"""Makes the faults of ``tests/faults.toml`` one at a time, and says of each whether its test notices it.

    python -m tests.faults [--only PATTERN]

A row names a line of the source, the same line with a fault, what a user would meet, and the test that notices. Each
fault is made in a copy of the working tree, never in the tree itself. Exit code 0 where every test notices its fault,
1 where one does not, or the line or the test is not there any more, 2 for bad input.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from tests.closure import ROOT
from tests.mutants import GRACE_S, SLOWER, Copy

LIST = "tests/faults.toml"
LIMIT_S = 600.0
"""All tests together, without a fault."""


class Fault(NamedTuple):
    """A row of the list."""

    file: str
    line: str
    """Without the spaces around it."""
    fault: str
    what: str
    """What a user would meet."""
    caught_by: str

    def error(self, root: Path) -> str:
        """Why the fault cannot be tried; empty if it can be."""
        path, (test, _, name) = root / self.file, self.caught_by.partition("::")
        count = sum(line.strip() == self.line for line in lines_of(path))
        if count != 1:
            return "line not found" if count == 0 else f"line found {count} times"
        defined = rf"(async )?def {re.escape(name.partition('[')[0])}\(.*"
        return "" if name and any(re.fullmatch(defined, line) for line in lines_of(root / test)) else "test not found"

    def made(self, code: str) -> str:
        """The code with the fault."""
        return re.sub(rf"(?m)^([ \t]*){re.escape(self.line)}[ \t]*$", lambda m: m[1] + self.fault, code)


def lines_of(path: Path) -> list[str]:
    """The lines of a file; none where there is no such file."""
    return path.read_text(encoding="utf-8").splitlines() if path.is_file() else []


def faults(root: Path) -> list[Fault]:
    """The rows of the list.

    Raises:
        OSError, tomllib.TOMLDecodeError, TypeError: no list, no TOML, or a row with other keys.
    """
    table = tomllib.loads((root / LIST).read_text(encoding="utf-8"))
    return [Fault(**row) for row in table.get("fault", [])]


def not_passing(copy: Copy, tests: Iterable[str]) -> tuple[set[str], float]:
    """Tests that do not pass without a fault, and the seconds that one test may take."""
    tests = sorted(set(tests))
    began = time.monotonic()
    if not tests or copy.run(tests, LIMIT_S) == 0:
        return set(), GRACE_S + SLOWER * (time.monotonic() - began)
    return {test for test in tests if copy.run([test], LIMIT_S) != 0}, LIMIT_S


def main(arguments: list[str] | None = None, root: Path = ROOT) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description="Whether tests notice known faults.")
    parser.add_argument("--only", metavar="PATTERN", default="", help="rows in which this regular expression is found")
    options = parser.parse_args(arguments)
    try:
        rows = [row for row in faults(root) if re.search(options.only, "\n".join(row))]
    except (OSError, tomllib.TOMLDecodeError, TypeError) as error:
        parser.error(f"{LIST}: {error}")
    except re.error as error:
        parser.error(f"--only {options.only}: {error}")
    if not rows:
        parser.error(f"no row of {LIST} has {options.only!r} in it")
    caught = 0
    with tempfile.TemporaryDirectory(prefix="leadscrew-faults-", ignore_cleanup_errors=True) as folder:
        copy = Copy(root, Path(folder))
        failing, limit_s = not_passing(copy, (row.caught_by for row in rows if not row.error(root)))
        for row in rows:
            result = row.error(root) or ("test fails without it" if row.caught_by in failing else "")
            if not result:
                code = (root / row.file).read_text(encoding="utf-8")
                copy.write(row.file, row.made(code))
                result = "survived" if copy.run([row.caught_by], limit_s) == 0 else "caught"
                copy.write(row.file, code)
            caught += result == "caught"
            print(f"{result:<21} {row.file}: {row.what}\n{'':21} {row.caught_by}", flush=True)
    print(f"{caught} of {len(rows)} caught")
    return 0 if caught == len(rows) else 1


if __name__ == "__main__":
    sys.exit(main())
