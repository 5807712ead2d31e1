"""Hostile names through every writer: an independent reader of each language finds the structure of a benign name."""

import ast
import copy
import csv
import io
import json
import re
import shlex
import shutil
import subprocess
import tomllib
import zipfile
from dataclasses import replace
from functools import cache, lru_cache
from html.parser import HTMLParser
from xml.etree import ElementTree as ET

import pytest
from markdown_it import MarkdownIt

from leadscrew import toml_file
from leadscrew.experiment import Experiment
from leadscrew.export.controller import export_controller
from leadscrew.export.folder import contents
from leadscrew.export.machine import machine_files
from leadscrew.fuzzy.engine import engine
from leadscrew.fuzzy.formats import WRITTEN, dumps, loads
from leadscrew.kernel.block import controller
from leadscrew.machine import file as machine_file
from leadscrew.operate import capture_files, script, session_file
from leadscrew.operate.operated import Session, Start
from leadscrew.paths.path import polyline
from leadscrew.report import html, page
from leadscrew.report.report import Section, StudyReport, TextTable
from leadscrew.tangent.emit import program
from leadscrew.tangent.settings import Settings
from leadscrew.tangent.stroke import strokes_of
from leadscrew.tune import worst
from leadscrew.util import escape
from leadscrew.util.errors import DataError, LeadscrewError, ValueRefused
from leadscrew.util.strict_json import strict
from tests.export.table import loop_of
from tests.operate.test_captures import capture
from tests.tools import missing

BENIGN = "emps axis"
HOSTILE = {
    "end of a C comment": "a */ #error b\n/*",
    "a C function": "a */\n__attribute__((constructor)) static void pwn(void){}\n/* b",
    "lines": 'a\nb\r\nc\td"\n[set]\nx = 1',
    "trigraph": "a ??/\nb??/",
    "backslash": "a\\",
    "splice": "a*\\\n/ b",
    "quotes": "a\"b'c\"\"\"d'''e",
    "Python": 'a"""\n    __import__("os").abort()\n    """ b',
    "script": "</script></pre></td><script>alert(1)</script>",
    "CDATA": "a ]]> --> <![CDATA[ b & &amp; &#0;",
    "table": "a | b | c",
    "Markdown": "a `b` ``c [d](javascript:e) ![f](http://g) *h* _i_ <b>j</b> $k$",
    "Jinja": "a {{ 7 * 7 }} {% raw %} b",
    "format": "a %n%s%d {0} b",
    "terminal": "a\x1b]0;b\x07\x1b[2J\x9bm\x00",
    "separators": "a\u2028b\u2029c\x85d",
    "bidirectional": "a\u202eb\u2066c",
    "surrogate": "a\ud800b",
    "not a character": "a\ufffeb\uffff",
    "long": "a" * 10_000,
    "LinuxCNC": " LogOpen, /home/cnc/.profile",
    "LinuxCNC Python": "py, import os) M3 (b",
    "formula": r"a $\undefined{b}$ $c",
}
OFTEN = ("end of a C comment", "lines", "trigraph", "quotes", "script", "table", "formula")
"""What is written in every run where writing takes long; the others in CI."""
each = pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
some = pytest.mark.parametrize(
    "text", [pytest.param(t, id=k, marks=[] if k in OFTEN else pytest.mark.slow) for k, t in HOSTILE.items()]
)


# ---- exports
@cache
def benign_core():
    loop = loop_of("pid").using({"controller.kp": 20.0})
    return loop, *export_controller(loop, 0.01, name="ours", title="title")


@cache
def exported(text):
    """The files of all targets with this text where foreign text can be."""
    loop, core, record = benign_core()
    loop = copy.copy(loop)
    loop.name = text
    core = replace(
        core, title=text, doc=text,
        inputs=tuple(replace(p, unit=text, doc=text) for p in core.inputs),
        outputs=tuple(replace(p, unit=text, doc=text) for p in core.outputs),
        knobs=tuple(replace(k, unit=text, doc=text, range=text, key=f"gains.{text}") for k in core.knobs),
        baked=(text,),
    )  # fmt: skip
    core = replace(core, files={**core.files, **machine_files(core)})
    golden = {"verdict": "not run", "note": "no compiler"}
    manifest = strict({**core.manifest, "title": text, "block": text, "loop": text, "golden": golden})
    found = {}
    for target in ("c99", "hal", "fmu2", "fmu3"):
        for name, data in contents(core, record, target, None, manifest, loop).items():
            if name.endswith(".fmu"):
                unit = zipfile.ZipFile(io.BytesIO(data))
                found |= {f"{target}/{n}": unit.read(n).decode() for n in unit.namelist()}
            else:
                found[f"{target}/{name}"] = data
    return found


TOKEN = re.compile(
    r"""(?P<comment>/\*.*?\*/|//[^\n]*)|(?P<string>"(?:\\.|[^"\\\n])*")|'(?:\\.|[^'\\\n])*'|\w+|\s+|(?P<open>["'])|.""",
    re.DOTALL,
)


def tokens(text):
    """The tokens of C as phases 1 to 3 of the standard make them; the contents of strings left out."""
    text = text.replace("??/", "\\").replace("\\\n", "")
    found = list(TOKEN.finditer(text))
    assert "".join(m[0] for m in found) == text and not any(m["open"] for m in found)
    return ['""' if m["string"] else m[0] for m in found if not m["comment"] and not m[0].isspace()]


@some
def test_c_and_halcompile_read_the_tokens_of_a_benign_export(text):
    benign, found = exported(BENIGN), exported(text)
    assert found.keys() == benign.keys()
    for name in found:
        if name.endswith((".c", ".h", ".comp")):
            guid = re.compile(r'"\{[0-9a-f-]{36}\}"')
            assert tokens(guid.sub('""', found[name])) == tokens(guid.sub('""', benign[name])), name
        if name.endswith(".comp"):
            assert found[name].count("\n;;\n") == 1


@each
def test_halcmd_reads_the_commands_of_a_benign_export(text):
    benign, found = exported(BENIGN), exported(text)
    for name in found:
        if name.endswith(".hal"):
            lines = [re.split(r"[\n\r\x0b\x0c]", files[name]) for files in (found, benign)]
            assert not any(x.endswith("\\") for x in lines[0])
            assert [x for x in lines[0] if x[:1] != "#"] == [x for x in lines[1] if x[:1] != "#"], name


@each
def test_an_xml_parser_reads_the_elements_of_a_benign_unit_and_the_name(text):
    def read(files):
        names = [n for n in sorted(files) if n.endswith("Description.xml")]
        assert len(names) == 3
        return [list(ET.fromstring(files[n]).iter()) for n in names]

    for mine, other in zip(read(exported(text)), read(exported(BENIGN)), strict=True):
        assert [(e.tag, list(e.attrib)) for e in mine if e.tag != "BaseUnit"] == [
            (e.tag, list(e.attrib)) for e in other if e.tag != "BaseUnit"
        ]
        if "modelName" in mine[0].attrib and escape.visible(text) == text:
            assert mine[0].get("modelName") == text


def shape(text):
    """The structure of a Markdown page, and its words."""
    flat = [t for top in MarkdownIt("commonmark").enable("table").parse(text) for t in (top, *(top.children or ()))]
    words = " ".join(t.content for t in flat if t.type in ("text", "code_inline"))
    return [t.type for t in flat if t.type not in ("text", "text_special", "softbreak", "code_inline", "inline")], words


@some
def test_a_markdown_parser_reads_the_structure_of_a_benign_readme(text):
    if text == HOSTILE["Markdown"]:  # The marks of a docstring stay; a name has none.
        kinds, words = shape(f"# {escape.markdown(text)}\n\n| {escape.markdown(text)} | b |\n|---|---|\n| c | d |\n")
        assert kinds == shape("# a\n\n| a | b |\n|---|---|\n| c | d |\n")[0]
        assert text in words.replace("  ", " ") or "![f](http://g)" in words
        return
    doc = re.compile(r"(?m)^ {4,}.*$")
    for name, found in exported(text).items():
        if name.endswith("README.md"):
            kinds, _ = shape(doc.sub("", found))
            assert kinds.count("tr_open") == shape(doc.sub("", exported(BENIGN)[name]))[0].count("tr_open"), name
            assert kinds.count("td_open") == shape(exported(BENIGN)[name])[0].count("td_open"), name
            assert not {"html_block", "html_inline", "image", "link_open"} & set(kinds), name


def test_a_docstring_keeps_its_marks_in_markdown_but_no_html_and_no_image():
    text = "``x`` and *y* of |e| <= 1, a < b\n\n- <script>z</script> ![a](http://b)"
    kinds, words = shape(escape.markdown_doc(text))
    assert kinds.count("em_open") == 1 and "<script>z</script>" in words
    assert not {"html_inline", "html_block", "image"} & set(kinds)
    assert escape.markdown_doc("``x`` of |e|", cell=True) == r"``x`` of \|e\|"


@pytest.mark.slow
def test_gcc_compiles_hostile_exports_without_a_warning(tmp_path):
    if shutil.which("gcc") is None:
        missing("gcc", "gcc is not installed")
    for at, text in enumerate(HOSTILE.values()):
        place = tmp_path / str(at)
        place.mkdir()
        for name, data in exported(text).items():
            target, _, file = name.partition("/")
            if target == "hal" or file.startswith("sources/"):
                (place / file.rsplit("/", 1)[-1]).write_text(data, "utf-8")
        flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]
        sources = sorted(p.name for p in place.glob("*.c"))
        done = subprocess.run(["gcc", *flags, *sources], cwd=place, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


# ---- pages
class Events(HTMLParser):
    """Tags with the names of their attributes, and the text between them."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.texts, self.values = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, tuple(k for k, _ in attrs)))
        self.values += [v for k, v in attrs if k in ("title", "alt")]

    def handle_endtag(self, tag):
        self.tags.append(f"/{tag}")

    def handle_data(self, data):
        self.texts.append(data)


@lru_cache(maxsize=1)
def short_run():
    return loop_of("pid").run(0.01)


def pages(text):
    run = short_run()
    held = replace(run, loop=loop_of("pid").using({"controller.kp": 20.0}), metrics={text: 1.0})
    held.loop.name = text
    yield held._repr_html_()
    yield page.page(text, [*page.paragraphs([text.replace("`", "")]), page.bullets(text, ["a"]),
                           page.table(TextTable([text], [[text]], title=text))])  # fmt: skip
    said = text.replace("`", "")  # backticks are code
    below = Section(said, [said], conclusion=said, anchor="below")
    report = StudyReport(text, text, text, [said], sections=[below], notes=[said], missed=[said], command=text)
    yield html.page(report, {"command": text, text: text}, {})
    yield exported(text)["fmu2/documentation/index.html"]


@each
def test_a_browser_reads_the_elements_of_a_benign_page_and_the_text(text):
    for mine, other in zip(pages(text), pages(BENIGN), strict=True):
        mine.encode()
        assert not re.search(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]", mine)
        assert Events(mine).tags == Events(other).tags
        if escape.visible(text) == text and "\r" not in text and "`" not in text:
            assert any(text in x for x in [*Events(mine).texts, *Events(mine).values])


@some
def test_a_figure_is_drawn_with_the_text_and_is_an_svg_that_parses(text):
    from matplotlib.figure import Figure

    if len(text) > 1000:
        return
    figure, out = Figure(), io.BytesIO()
    figure.suptitle(escape.figure(text))
    figure.savefig(out, format="svg")
    ET.fromstring(out.getvalue())


# ---- programs and files
@each
def test_toml_gives_the_same_text_back(text):
    if "\ud800" in text:
        for write in (lambda: toml_file.text({"a": text}), lambda: toml_file.text({text: 1})):
            with pytest.raises(ValueRefused, match="cannot be written as TOML: it is no Unicode text"):
                write()
        return
    table = {"a": text, "list": [text], "files": {text: "b", "lathe.toml": "c"}, "log": {"columns": {text: "d"}}}
    assert tomllib.loads(toml_file.text(table)) == table
    asked = Experiment("vud_lathe", None, text, changes={"a.b": text}, files={text: "c", "lathe.toml": "d"})
    read = tomllib.loads(worst.toml(asked, text))
    assert read["scenario"] == text and read["set"] == {"a": {"b": text}}
    assert read["files"] == {text: "c", "lathe.toml": "d"}
    session = Session(Start("vud_lathe", None, text, {}, files={"lathe.toml": "e"}), (), 10, "ab" * 32)
    read = tomllib.loads(session_file.text(session))["start"], tomllib.loads(session_file.text(session))["files"]
    assert read[0]["scenario"] == text and read[1] == {"lathe.toml": "e"}


SYSTEM = """Engine: a
InputVariable: x
  enabled: true
  range: 0 1
  lock-range: false
  term: lo Ramp 1 0
  term: hi Ramp 0 1
OutputVariable: y
  enabled: true
  range: 0 1
  lock-range: false
  aggregation: Maximum
  defuzzifier: Centroid 100
  default: nan
  lock-previous: false
  term: hi Ramp 0 1
RuleBlock: r
  enabled: true
  conjunction: none
  disjunction: none
  implication: Minimum
  activation: General
  rule: if x is lo then y is hi
"""


def fuzzy(text):
    """A system whose every name is the text, as XML can hold it."""
    system = loads(SYSTEM, "fll")
    rename = {"x": f"{text} 1", "y": f"{text} 2"}
    inputs, outputs = (
        tuple(replace(v, name=rename[v.name], terms=tuple(replace(t, name=f"{text} {t.name}") for t in v.terms))
              for v in side)
        for side in (system.inputs, system.outputs)
    )  # fmt: skip

    def named(x):
        return replace(x, variable=rename[x.variable], term=f"{text} {x.term}")

    rules = tuple(
        replace(r, antecedent=named(r.antecedent), consequents=tuple(map(named, r.consequents))) for r in system.rules
    )
    blocks = tuple(replace(b, name=text, rules=rules) for b in system.blocks)
    return replace(system, name=text, doc=text, inputs=inputs, outputs=outputs, blocks=blocks)


@each
def test_the_step_of_a_fuzzy_system_holds_the_code_of_a_benign_one(text):
    mine, other = (ast.parse(engine(fuzzy(t)).text) for t in (text, BENIGN))
    assert [type(n) for n in ast.walk(mine)] == [type(n) for n in ast.walk(other)]


def test_the_name_of_a_fuzzy_system_in_a_file_is_not_run():
    """It was: as the end of a docstring, when the step ran in Python."""
    evil = 'a"""; globals().update(PWNED=1); """'
    space = engine(loads(SYSTEM.replace("Engine: a", f"Engine: {evil}"), "fll")).space
    assert space["infer"].__doc__ == f"The outputs y of {evil}."


@each
@pytest.mark.parametrize("form", WRITTEN)
def test_a_fuzzy_system_is_read_again_as_the_same_rules_or_refused(text, form):
    system = fuzzy(text)
    try:
        written = dumps(system, form)
    except ValueRefused as refused:
        assert "cannot express" in str(refused)
        return
    again = loads(written, form)
    at, same = ([*s(**{s.inputs[0].name: 0.25}).values()] for s in (again, system))
    assert at == same
    assert [len(v.terms) for v in (*again.inputs, *again.outputs)] == [2, 1] and len(again.rules) == 1


@each
def test_a_script_of_a_session_holds_the_code_of_a_benign_one(text):
    mine, other = (
        ast.parse(script.text(Session(Start(t, None, t), (), 10, "ab" * 32), 1e-3, t).encode("utf-8", "replace"))
        for t in (text, BENIGN)
    )
    assert [type(n) for n in ast.walk(mine)] == [type(n) for n in ast.walk(other)]


@each
def test_g_code_is_that_of_a_benign_note_in_lines_that_linuxcnc_takes(text):
    settings = Settings()
    strokes = strokes_of([polyline([(0.0, 0.0), (10.0, 0.0)])], settings)
    mine, other = (program(strokes, settings, [t]).splitlines() for t in (text, BENIGN))
    assert len(mine) == len(other) and max(map(len, mine)) < 255
    (note,) = [x for x, y in zip(mine, other, strict=True) if x != y]
    assert re.fullmatch(r"\([ -'*-~]*\)", note)
    assert not re.match(r"\(\s*(msg|debug|print|log\w*|probe\w*|py\w*)\s*,", note, re.IGNORECASE)


@each
def test_a_capture_is_read_again_from_csv(text, tmp_path):
    if "\ud800" in text or not text.isprintable():
        text = escape.one_line(text)
    one = replace(capture(), name=text, about={"note": text}, units={"command": text})
    rows = list(csv.reader(io.StringIO(capture_files.csv_of(one).decode())))
    assert sum(not r[0].startswith("#") for r in rows) == 201
    assert all(json.dumps(r) for r in rows)


# ---- where names enter
@pytest.mark.parametrize("text", [HOSTILE[k] for k in ("lines", "terminal", "separators", "surrogate", "long")])
def test_a_name_is_one_printable_line_of_bounded_length_where_it_enters(text, tmp_path):
    rule = "expected one line of printable characters, 1000 at most"
    with pytest.raises(ValueRefused, match=rule):
        loop_of("pid").using(name=text)
    with pytest.raises(ValueRefused, match=rule):
        export_controller(loop_of("pid"), 0.01, name="ours", title=text)
    with pytest.raises(ValueRefused, match=rule):
        controller(name=text)(lambda command, feedback: command - feedback)
    with pytest.raises(LeadscrewError) as refused:
        machine_file.validated({"schema_version": 1, "kind": "machine", "name": text, "model": "linear",
                                "position_unit": "mm", "drive_unit": "V", "period": 0.001}, tmp_path)  # fmt: skip
    assert isinstance(refused.value, DataError) and "name" in str(refused.value)
    assert loop_of("pid").using(name="").name == ""


def test_part_of_a_file_name_leads_out_of_no_folder_and_is_short():
    for text in (*HOSTILE.values(), "..", "../../a", ".profile", "a/b", "C:\\b", "a\x00"):
        name = escape.file_name(text)
        assert re.fullmatch(r"[^\W.][\w.-]*|_[\w.-]*", name) and len(name) <= 150


@each
def test_a_shell_takes_a_path_of_a_command_as_one_word(text):
    assert shlex.split(f"leadscrew simulate {escape.shell(text)} -s move", comments=True)[2] == text
