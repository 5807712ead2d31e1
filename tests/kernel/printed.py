"""Steps as printed C, run over rows of inputs: ``NAME.c`` as exported, compiled at a level, beside what Python gives."""

import ast
import ctypes
import subprocess
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.export.source import Source
from leadscrew.kernel.block import make
from leadscrew.kernel.layout import is_branch
from leadscrew.kernel.module import Module, _Division
from leadscrew.kernel.probe import _copied
from leadscrew.kernel.trees import copied

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


class _Truth(ast.NodeTransformer):
    """Comparisons that give Python's own truth values, of NumPy's numbers too."""

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        self.generic_visit(node)
        return ast.Call(ast.Name("bool", ast.Load()), [node], [])


def namespace(module: Module) -> dict[str, Any]:
    """The module's functions in plain Python."""
    space = module.namespace()
    for item in module.ordered():
        if isinstance(item.node, ast.FunctionDef):
            node = _Truth().visit(copied(item.node) if item.trusted else _Division().visit(copied(item.node)))
            exec(compile(ast.fix_missing_locations(ast.Module([node], [])), item.filename, "exec"), space)
    return space


def first_output(source: Source) -> Any:
    """What the step gives in its first period."""
    block = source.block
    lead = [x for x in (source.prepared, _copied(source.state)) if x is not None]
    given = {**source.signals, "t": 0.0, "dt": PERIOD}
    with np.errstate(all="ignore"):
        made = namespace(source.module)[source.step](*lead, *(given[n] for n in block.signals))
    return made[1] if block.state is not None else made


def by_python(source: Source, inputs: np.ndarray) -> np.ndarray:
    """What the module's own Python gives, row by row from the start."""
    step = namespace(source.module)[source.step]
    block, p, s = source.block, source.prepared, _copied(source.state)
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
    made = []
    for source in sources:
        for name, text in {**source.files(), f"{source.name}_run.c": runner(source)}.items():
            (folder / name).write_text(text, encoding="utf-8")
            if name.endswith(".c"):
                made.append(folder / name)
    return made


def library(files: list[Path], *flags: str, compiler: tuple[str, ...] = ("gcc",)) -> ctypes.CDLL:
    """The files as one shared library; any warning fails."""
    made = files[0].parent / f"all{''.join(flags)}{Path(compiler[0]).name}.so"
    command = [*compiler, *STRICT, *flags, "-fPIC", "-shared", "-o", str(made), *map(str, files), "-lm"]
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
