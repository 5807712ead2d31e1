"""What the C printer may stumble over: names, comments, kinds of numbers, effects, warnings; and random steps."""

import shutil
import subprocess

import numpy as np
import pytest

from leadscrew.export.single import replay
from leadscrew.kernel.c99 import comments
from leadscrew.kernel.c99.names import LIBRARY, safe, safe_field
from leadscrew.util.errors import SubsetError
from tests.budget import some
from tests.kernel import nasty, printed, test_agreement, test_subset
from tests.kernel.differential import differences
from tests.kernel.printed import rows, same
from tests.tools import missing

REALS = ("double", "float")
A, T = test_agreement, test_subset
STEPS = {
    **nasty.STEPS,
    **{f.__name__: (f, A.P(), A.S(), {}) for f in (*A.STEPS, A.last_element_set)},
    **{f.__name__: (f, A.P(), A.S(), {}) for f in A.ONE_MEANING if f not in (A.whole_or_half, A.large_literal)
       and "write" not in f.__name__},
    "rich": (T.rich, T.P(), T.S(), {}), "floor_and_mod": (T.floor_and_mod, T.P(a=-0.7), None, {}),
    "all_set": (T.all_set, None, None, {}), "local_zeros": (T.local_zeros, None, None, {}),
    "either_end": (T.either_end, None, None, {}), "local_ring": (T.local_ring, T.P(), T.Ring(), {}),
}  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def gcc():
    if shutil.which("gcc") is None:
        missing("gcc", "gcc is not installed")


LEVEL = {
    "-O2": [],
    **{level: [pytest.mark.slow, pytest.mark.xdist_group(f"printed {level}")] for level in ("-O0", "-O3")},
}


@pytest.fixture(scope="module", params=[pytest.param(level, marks=marks) for level, marks in LEVEL.items()])
def made(request, tmp_path_factory):
    """Every step, double and float, in one library."""
    folder = tmp_path_factory.mktemp("printed")
    sources = {}
    for real in REALS:
        for i, (name, (step, p, s, signals)) in enumerate(STEPS.items()):
            title = f"{'axis' if name == 'bad_names' else f'a{i}'}{'' if real == 'double' else 'f'}"
            sources[name, real] = printed.source_of(step, p, s, name=title, real=real, **signals)
    files = printed.written(list(sources.values()), folder)
    return sources, printed.library(files, request.param)


@pytest.mark.parametrize("real", REALS)
@pytest.mark.parametrize("name", STEPS)
def test_a_printed_step_gives_what_python_gives(name, real, made):
    source, given = made[0][name, real], rows(len(made[0][name, real].inputs))
    want = printed.by_python(source, given) if real == "double" else replay(source, given)
    assert same(printed.played(made[1], source, given), want)


@pytest.mark.parametrize("step", A.STEPS, ids=lambda f: f.__name__)
def test_a_step_gives_in_a_loop_in_c_what_it_gives_in_machine_code(step):
    a, b = (A.on_engine(step, engine)["output"] for engine in ("llvm", "c"))
    assert same(a, b)


# ---- random steps
@pytest.mark.slow
@pytest.mark.parametrize("seed", some(range(100, 110), 5))
def test_random_steps_are_the_same_bits_everywhere_and_have_no_undefined_behaviour(seed, tmp_path):
    assert differences(seed, 14, tmp_path, ("-O0", "-O3"), REALS) == []
    files = sorted(f for real in REALS for f in (tmp_path / real).glob("*.c"))
    runs = [f"{f.stem}_run" for f in files if f.stem != "run"]
    numbers = ", ".join(printed.c_number(x) for x in rows(2).ravel().tolist())
    size = len(rows(2))
    main = tmp_path / "main.c"
    main.write_text(
        "#include <math.h>\n#include <stdint.h>\n"
        + "".join(f"void {r}(const double *in, double *out, int64_t rows);\n" for r in runs)
        + f"static const double in[] = {{{numbers}}};\nstatic double out[{size}];\nint main(void)\n{{\n"
        + "".join(f"    {r}(in, out, {size});\n" for r in runs)
        + "    return 0;\n}\n"
    )
    flags = ("-std=c99", "-O1", "-fsanitize=undefined,float-cast-overflow,address", "-fno-sanitize-recover=all")
    command = ["gcc", *flags, "-ffp-contract=off", "-o", str(tmp_path / "checked"), str(main), *map(str, files), "-lm"]
    subprocess.run(command, check=True)
    done = subprocess.run([str(tmp_path / "checked")], capture_output=True, text=True, check=False)
    assert not done.returncode, done.stderr[:2000]


# ---- refusals


def own_array(x):
    room = np.zeros(2)
    room[0] = x
    return room


def takes_array(command):
    return own_array(command)[0]


@pytest.mark.parametrize(
    ("step", "params", "says"),
    [
        (takes_array, None, "a function that returns an array of its own"),
    ],
    ids=lambda x: getattr(x, "__name__", None),
)
def test_what_cannot_be_translated_is_refused_by_file_line_and_construct(step, params, says):
    with pytest.raises(SubsetError, match=says) as caught:
        printed.source_of(step, params).files()
    assert str(caught.value).startswith("test_c99_printer.py:") and "\n" not in str(caught.value)


# ---- names and comments
HEADERS = ("math.h", "stdbool.h", "stdint.h", "string.h", "float.h", "stddef.h")


@pytest.mark.parametrize("compiler_", [("gcc", "-std=c99"), ("gcc", "-std=gnu17"), ("g++", "-xc++")], ids=str)
def test_no_name_of_a_local_or_field_is_a_macro_of_the_headers(compiler_):
    if shutil.which(compiler_[0]) is None:
        missing(compiler_[0], f"{compiler_[0]} is not installed")
    text = "".join(f"#include <{h}>\n" for h in HEADERS)
    said = subprocess.run([*compiler_, "-dM", "-E", "-"], input=text, capture_output=True, text=True, check=True).stdout
    macros = {line.split()[1] for line in said.splitlines()}
    plain = {m for m in macros if "(" not in m and not m.startswith("_")}
    assert "NAN" in plain and len(plain) > 50
    assert not {m for m in plain if safe(m) == m}
    assert not {m for m in plain if safe_field(m) == m}


def test_no_function_has_the_name_of_one_that_the_compiler_knows(tmp_path):
    names = sorted(LIBRARY)
    text = "".join(f"static inline double {safe(n)}(double a, double b) {{ return a + b; }}\n" for n in names)
    file = tmp_path / "names.c"
    file.write_text("".join(f"#include <{h}>\n" for h in HEADERS) + text)
    subprocess.run(["gcc", *printed.STRICT, "-c", "-o", str(tmp_path / "names.o"), str(file)], check=True)


def test_two_fields_never_share_a_name():
    names = ["int", "int_", "int__", "period", "period_", "NAN", "NAN_", "x", "x_", "DBL_MAX", "DBL_MAX_"]
    assert len({safe_field(n) for n in names}) == len(names)
    assert safe_field("x_") == "x_" and safe_field("int") == "int_"


@pytest.mark.parametrize("text", ["*/", "*``/", "/*/", "**//*", "??/", "a *?``?/", "\u202e", "\x00\x1b", "*" * 9 + "/"])
def test_a_comment_stays_a_comment(text, tmp_path):
    lines = comments.block([text, text + text, ""], f"{text}.py:3") + comments.block([text])
    file = tmp_path / "comment.c"
    file.write_text(f"{lines}int main(void) {{ return 0; }}\n", encoding="utf-8")
    subprocess.run(["gcc", *printed.STRICT, "-o", str(tmp_path / "comment"), str(file)], check=True)
