"""The package as others receive it: typed, light to import, its version the same everywhere."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib import metadata, resources
from pathlib import Path

import pytest

import leadscrew

ROOT = Path(__file__).parents[1]
HEAVY = {"numpy", "llvmlite", "scipy", "matplotlib", "pyarrow", "pydantic", "typer", "rich", "jinja2"}


def modules_after(code: str) -> set[str]:
    """Top-level modules that a fresh interpreter has loaded after ``code``."""
    show = "import sys; print(*sorted({m.split('.')[0] for m in sys.modules}))"
    done = subprocess.run([sys.executable, "-c", f"{code}\n{show}"], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_import_is_light() -> None:
    assert not modules_after("import leadscrew") & HEAVY


def test_declaring_a_block_needs_no_compiler() -> None:
    code = "from leadscrew import Doc, Ge, Gt, Le, Lt, Unit, controller, plant, reference, LeadscrewError"
    assert not modules_after(code) & HEAVY


def test_every_public_name_is_there() -> None:
    for name in leadscrew.__all__:
        assert getattr(leadscrew, name) is not None
    assert set(leadscrew.__all__) <= set(dir(leadscrew))


def test_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Lopo'") as caught:
        leadscrew.Lopo  # noqa: B018
    assert (caught.value.name, caught.value.obj) == ("Lopo", leadscrew)


def test_types_are_shipped() -> None:
    assert resources.files("leadscrew").joinpath("py.typed").is_file()


def test_version_is_the_same_everywhere() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    top = re.search(r"^## \[(\d[^\]]*)\]", changelog, re.MULTILINE)
    cited = re.search(r"^version: (\S+)", citation, re.MULTILINE)
    assert top and top.group(1) == leadscrew.__version__
    assert cited and cited.group(1).strip('"') == leadscrew.__version__
    assert metadata.version("leadscrew") == leadscrew.__version__


def test_constraints_are_names_and_versions_only() -> None:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    for line in lines:
        assert line.startswith("#") or re.fullmatch(r"[A-Za-z0-9._-]+==[0-9][A-Za-z0-9.!+]*", line), line


def test_constraints_cover_what_the_package_asks_for() -> None:
    normal = re.compile(r"[-_.]+")
    pinned = {normal.sub("-", x.split("==")[0]).lower() for x in (ROOT / "constraints.txt").read_text().splitlines()}
    for requirement in metadata.requires("leadscrew") or ():
        name = re.match(r"[A-Za-z0-9._-]+", requirement)
        assert name and normal.sub("-", name.group()).lower() in pinned, requirement


def test_no_machine_addresses_in_what_is_shipped() -> None:
    files = [
        ROOT / n for n in ("README.md", "Makefile", "constraints.txt", "pyproject.toml", ".ci/run", "CONTRIBUTING.md")
    ]
    files += [*(ROOT / "docs").glob("*.md"), *(ROOT / "docs").glob("*.py")]
    for file in files:
        text = file.read_text(encoding="utf-8")
        for banned in ("index-" + "url", "files.pythonhosted", "/simple", "/root/", "/home/", "/work/"):
            assert banned not in text, f"{file.name}: {banned}"
