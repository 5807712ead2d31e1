"""What LinuxCNC's recorders write, as lines of a plain table.

The oscilloscope ``halscope`` of LinuxCNC 2.9 writes a comment ``# Sampling period is 1000000 ns`` and a table with
semicolons; older ones wrote ``Sampling period is 1000000 nSec`` and rows of ``name +value name +value``. ``halsampler``
writes bare rows with white space between the cells, and ``overrun`` on a line of its own where samples were lost.
Source: LinuxCNC, src/hal/utils/scope_files.c; halsampler(1).
"""

from __future__ import annotations

import re

from leadscrew.logs.sniff import Line

_PAIR = re.compile(r"(\S+) ([-+]\d+\.\d+)(?: |$)")


def recorder(lines: list[Line], comments: list[str]) -> tuple[list[Line], list[int], str]:
    """Lines as a plain table, rows of the file at which samples were lost, and which recorder it was."""
    lost = [row for row, text in lines if text.strip() == "overrun"]
    if lost:
        lines = [line for line in lines if line[1].strip() != "overrun"]
        return lines, lost, "LinuxCNC halsampler"
    if not lines[0][1].startswith("Sampling period is ") or len(lines) < 2:
        scope = any(c.startswith("Sampling period is ") and c.endswith(" ns") for c in comments[:1])
        return lines, [], "LinuxCNC halscope" if scope else ""
    comments.append(lines[0][1].strip())
    pairs = [(row, _PAIR.findall(text)) for row, text in lines[1:]]
    names = [name for name, _ in pairs[0][1]]
    body = [(row, ";".join(value for _, value in found)) for row, found in pairs]
    return [(lines[0][0], ";".join(names)), *body], [], "LinuxCNC halscope"
