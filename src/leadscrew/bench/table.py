"""The rows as a Markdown table: ``leadscrew bench --json | python -m leadscrew.bench.table``."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping
from typing import Any

HEAD = ("Row", "What", "Measured", "Ratio", "Target", "Met", "Integrator", "Error, mm", "Remark")
VERDICTS = {True: "yes", False: "**no**", None: ""}


def _number(x: float | None, form: str) -> str:
    return "" if x is None else format(x, form)


def markdown(rows: Iterable[Mapping[str, Any]]) -> str:
    """A table for a page."""
    cells = [
        (
            r["name"], r["what"], f"{_number(r['value'], ',.3g' if abs(r['value'] or 0.0) < 1000 else ',.0f')} {r['unit']}".strip(),
            _number(r["ratio"], ",.2f" if (r["ratio"] or 0.0) < 100 else ",.0f"), r["target"], VERDICTS[r["passed"]],
            r["integrator"], _number(r["error"], ".1e"), r["remark"],
        )
        for r in rows
    ]  # fmt: skip
    lines = [HEAD, ("---", "---", "--:", "--:", "---", "---", "---", "--:", "---"), *cells]
    return "\n".join("| " + " | ".join(c.replace("|", "/") for c in line) + " |" for line in lines)


if __name__ == "__main__":
    print(markdown(json.load(sys.stdin)["rows"]))
