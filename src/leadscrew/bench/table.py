"""The rows as a Markdown table: ``leadscrew bench --json | python -m leadscrew.bench.table``."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping
from typing import Any

from leadscrew.util.escape import markdown_doc

HEAD = ("Row", "What", "Measured", "Ratio", "Target", "Met", "Integrator", "Error, mm", "Remark")
VERDICTS = {True: "yes", False: "**no**", None: ""}


def _number(x: float | None, limit: float) -> str:
    """Three digits, in whole numbers from ``limit`` on."""
    return "" if x is None else f"{x:,.0f}" if x >= limit else f"{x:#.3g}"


def markdown(rows: Iterable[Mapping[str, Any]]) -> str:
    """A table for a page."""
    cells = [
        (
            r["name"], r["what"], f"{_number(r['value'], 100.0)} {r['unit']}".strip(), _number(r["ratio"], 100.0),
            r["target"], VERDICTS[r["passed"]], r["integrator"],
            "" if r["error"] is None else f"{r['error']:.1e}", r["remark"],
        )
        for r in rows
    ]  # fmt: skip
    lines = [HEAD, ("---", "---", "--:", "--:", "---", "---", "---", "--:", "---"), *cells]
    return "\n".join("| " + " | ".join(markdown_doc(c, cell=True) for c in line) + " |" for line in lines)


if __name__ == "__main__":
    print(markdown(json.load(sys.stdin)["rows"]))
