"""The exported C of a controller called without the layer of the machine around it, by a program of a few lines."""

import subprocess

import numpy as np

from leadscrew.export.controller import export_controller
from leadscrew.export.folder import compiler_path
from tests.tools import missing

MAIN = """#include "bare.h"
#include <stdio.h>
#include <stdlib.h>
int main(void)
{
    bare_params params;
    bare_state state;
    double x[%d];
    int n = 0;
    char text[64];

    bare_defaults(&params);
    bare_start(&params, &state);
    while (scanf("%%63s", text) == 1) {
        x[n++] = strtod(text, NULL);
        if (n == %d) {
            n = 0;
            printf("%%.17g\\n", bare_step(&params, &state, %s));
        }
    }
    return 0;
}
"""


def stepped(loop, rows, folder):
    """Outputs of ``NAME_step`` for rows of inputs, from its start state; NaN and infinity are numbers like others."""
    compiler = compiler_path()
    if compiler is None:
        missing("gcc", "there is no C compiler on this machine")
    core, _ = export_controller(loop, 5 * loop.period, name="bare", title="bare")
    for name, text in core.files.items():
        (folder / name).write_text(text, encoding="utf-8")
    width = rows.shape[1]
    (folder / "main.c").write_text(MAIN % (width, width, ", ".join(f"x[{i}]" for i in range(width))), encoding="utf-8")
    made = folder / "bare"
    flags = ["-O2", "-std=c99", "-ffp-contract=off"]
    subprocess.run([compiler, *flags, "main.c", "bare.c", "-o", made, "-lm"], cwd=folder, check=True, timeout=60)
    given = "\n".join(" ".join(repr(x) for x in row) for row in rows.tolist())
    done = subprocess.run([made], input=given, capture_output=True, text=True, check=True, timeout=60)
    return np.array([float(line) for line in done.stdout.split()])
