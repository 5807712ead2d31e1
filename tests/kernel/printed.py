"""Steps as exported C, compiled and run over rows of inputs; and what plain Python gives for the same rows."""

import ctypes
import subprocess
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.export.source import Source
from leadscrew.kernel.block import make
from leadscrew.kernel.layout import copied, is_branch

STRICT = ("-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-ffp-contract=off")
PERIOD = 1e-3


def source_of(
    step: Any, params: Any = None, state: Any = None, *, name: str = "axis", real: str = "double",
    command: Any = 0.5, feedback: Any = 0.25, **more: Any,
) -> Source:  # fmt: skip
    """The source of a step for signals like the examples."""
    block = step if hasattr(step, "step") else make("controller", step, params, state, **more)
    source = Source(
        block, block.params, block.state, {"command": command, "feedback": feedback, "output": 0.0}, name=name,
        period=PERIOD, real=real, head="/* made by a test */\n",
    )  # fmt: skip
    source.signals["output"] = first_output(source)
    source.outputs = [type(a)(a.key, a.name) for a in source.arguments("output")]
    return source


def first_output(source: Source) -> Any:
    """What the step gives in its first period."""
    block = source.block
    lead = [x for x in (source.prepared, copied(source.state)) if x is not None]
    given = {**source.signals, "t": 0.0, "dt": PERIOD}
    with np.errstate(all="ignore"):
        made = source.module.namespace()[source.step](*lead, *(given[n] for n in block.signals))
    return made[1] if block.state is not None else made


def by_python(source: Source, inputs: np.ndarray) -> np.ndarray:
    """What the module's own Python gives, row by row from the start."""
    step = source.module.namespace()[source.step]
    block, p, s = source.block, source.prepared, copied(source.state)
    names = [a.key for a in source.inputs]
    out = []
    with np.errstate(all="ignore"):
        for k, row in enumerate(inputs.tolist()):
            given = dict(zip(names, row, strict=True))
            known = {"t": k * PERIOD, "dt": PERIOD}
            args = [known[n] if n in known else source.filled(n, given, float) for n in block.signals]
            result = step(*(x for x in (p, s) if x is not None), *args)
            if s is not None:
                held = s
                s, result = result
                s = kept(held, s)
            out.append([float(x) for x in source.numbers(result)])
    return np.array(out)


def kept(held: Any, new: Any) -> Any:
    """The next state, its arrays those of the state before, as a loop keeps them."""
    if is_branch(new):
        return type(new)(*(kept(a, b) for a, b in zip(held, new, strict=True)))
    return held if isinstance(held, np.ndarray) else new


def runner(source: Source) -> str:
    """C that plays rows of inputs through a printed step."""
    n, real = source.name, source.real.c
    m, outs = len(source.inputs), len(source.outputs)
    ins = ", ".join(f"({real})in[{m} * k + {i}]" for i in range(m))
    lead = f"&params, &state{', ' if m else ''}{ins}"
    if outs == 1:
        body = f"out[k] = {n}_step({lead});"
    else:
        given = ", ".join(f"&y[{i}]" for i in range(outs))
        body = f"{n}_step({lead}, {given});\n" + "".join(f"out[{outs} * k + {i}] = y[{i}];\n" for i in range(outs))
    held = "" if outs == 1 else f"{real} y[{outs}];\n"
    return (
        f'#include "{n}.h"\nvoid {n}_run(const double *in, double *out, int64_t rows);\n'
        f"void {n}_run(const double *in, double *out, int64_t rows)\n{{\n{n}_params params;\n{n}_state state;\n{held}"
        f"int64_t k;\n(void)in;\n{n}_defaults(&params);\n{n}_start(&params, &state);\n"
        f"for (k = 0; k < rows; k++) {{\n{body}\n}}\n}}\n"
    )


def written(sources: list[Source], folder: Path) -> list[Path]:
    """The files of sources and what plays them; returns the C files."""
    folder.mkdir(parents=True, exist_ok=True)
    made = [folder / "run.c"]
    for source in sources:
        for name, text in source.files().items():
            (folder / name).write_text(text, encoding="utf-8")
            if name.endswith(".c"):
                made.append(folder / name)
    made[0].write_text("".join(runner(source) for source in sources), encoding="utf-8")
    return made


def library(files: list[Path], *flags: str) -> ctypes.CDLL:
    """The files as one shared library; any warning fails."""
    made = files[0].parent / f"all{''.join(flags)}.so"
    command = ["gcc", *STRICT, *flags, "-fPIC", "-shared", "-o", str(made), *map(str, files), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert not done.returncode, done.stderr[:3000]
    return ctypes.CDLL(str(made))


def played(made: ctypes.CDLL, source: Source, inputs: np.ndarray) -> np.ndarray:
    """Outputs of a printed step over rows of inputs."""
    given = np.ascontiguousarray(inputs, dtype=np.float64)
    out = np.full((len(given), len(source.outputs)), -77.0)
    run = getattr(made, f"{source.name}_run")
    run.argtypes, run.restype = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64), None
    run(given.ctypes.data, out.ctypes.data, len(given))
    return out


def same(a: np.ndarray, b: np.ndarray) -> bool:
    """Equal to the last bit, signs of zero included; any NaN is as good as another."""
    nan = np.isnan(a) & np.isnan(b)
    return a.shape == b.shape and bool(np.all(nan | (a.view(np.int64) == b.view(np.int64))))


SPECIAL = (0.0, -0.0, 1.0, -1.0, 0.3, 0.6, 0.26, -0.7, 2.5, 3.0, -7.5, 5e-324, -1e-310, 1e16, 1e308, -1e308, np.inf,
           -np.inf, np.nan, 0.1)  # fmt: skip


def rows(columns: int) -> np.ndarray:
    """Rows of inputs: every pair of special numbers, in an order that mixes them."""
    pairs = np.array([[a, b] for a in SPECIAL for b in reversed(SPECIAL)])
    np.random.default_rng(0).shuffle(pairs)
    return np.ascontiguousarray(np.hstack([pairs] + [np.full((len(pairs), 1), 0.5)] * 8)[:, :columns])


def c_number(x: float) -> str:
    """A double as C source."""
    return repr(x) if np.isfinite(x) else "NAN" if np.isnan(x) else "INFINITY" if x > 0 else "-INFINITY"
