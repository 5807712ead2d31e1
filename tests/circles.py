"""Import circles of the library: ``python -m tests.circles`` prints them, and exits with 1 if there are any.

Imports in functions count; those for type checkers alone do not.
"""

from __future__ import annotations

import sys

import grimp
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components


def circles() -> tuple[int, list[list[str]]]:
    """How many modules there are, and those that reach each other."""
    graph = grimp.build_graph("leadscrew", exclude_type_checking_imports=True, cache_dir=None)
    modules = sorted(graph.modules)
    place = {module: i for i, module in enumerate(modules)}
    arrows = [(place[a], place[b]) for a in modules for b in graph.find_modules_directly_imported_by(a)]
    rows, columns = zip(*arrows, strict=True)
    matrix = csr_matrix((np.ones(len(arrows)), (rows, columns)), shape=(len(modules),) * 2)
    count, labels = connected_components(matrix, connection="strong")
    members = [[m for m, k in zip(modules, labels, strict=True) if k == label] for label in range(count)]
    return len(modules), sorted(group for group in members if len(group) > 1)


if __name__ == "__main__":
    number, found = circles()
    print(f"{number} modules, {len(found)} import circles")
    for group in found:
        print("   ", ", ".join(group))
    sys.exit(bool(found))
