"""The catalogue: every row resolves, every block has a row, plug-ins and files of one's own join."""

from __future__ import annotations

import importlib
import pkgutil
import re
import types
from pathlib import Path

import pytest

from leadscrew import catalogue, names, resolve
from leadscrew.kernel.block import KINDS, Block
from leadscrew.util.errors import BlockError, DataError, LeadscrewError, NameUnknown

ROOT = Path(__file__).parents[1]
PACKAGES = ("references", "sensors", "actuators", "disturbances", "controllers", "plants")


def test_every_row_is_a_block_of_its_name():
    for name, block in catalogue.blocks().items():
        assert isinstance(block, Block) and block.kind in KINDS
        assert block.name == name.removeprefix("metrics.") and block.doc


def test_every_row_of_the_other_tables_resolves():
    assert all(callable(made) and made.__doc__ for made in catalogue.factories().values())
    assert {catalogue.factory_kind(n) for n in catalogue.FACTORIES} <= set(KINDS)
    for name in catalogue.STUDIES:
        assert resolve.study(name).name == name


def test_every_block_of_the_library_has_a_row():
    known = {id(block) for block in catalogue.blocks().values()}
    missing = []
    for package in PACKAGES:
        home = importlib.import_module(f"leadscrew.{package}")
        for info in pkgutil.walk_packages(home.__path__, f"{home.__name__}."):
            for name, block in vars(importlib.import_module(info.name)).items():
                if isinstance(block, Block) and block.step.__module__ == info.name and not name.startswith("_"):
                    missing += [f"{info.name}.{name}"] if id(block) not in known else []
    assert not missing, f"give these blocks a row in leadscrew/catalogue.py: {missing}"


def test_packages_of_blocks_export_blocks_and_no_modules():
    for package in PACKAGES:
        home = importlib.import_module(f"leadscrew.{package}")
        shown = {name: getattr(home, name) for name in home.__all__ if name != "grating"}
        assert shown and not [name for name, value in shown.items() if isinstance(value, types.ModuleType)]
    from leadscrew.controllers import pid

    assert pid(kp=2.0).params.kp == 2.0


def test_every_standard_metric_has_a_row():
    from leadscrew.kernel.metrics import STANDARD

    assert {n.removeprefix("metrics.") for n in catalogue.BLOCKS if n.startswith("metrics.")} == set(STANDARD)


def test_an_unknown_name_gets_the_nearest():
    with pytest.raises(NameUnknown, match=r"did you mean .*lathe_servo"):
        resolve.block("lathe_srvo")
    with pytest.raises(NameUnknown, match="vud_lathe"):
        resolve.study("vud")
    with pytest.raises(BlockError, match="state_space"):
        resolve.block("state_space")
    with pytest.raises(BlockError, match="is a reference, not a controller"):
        resolve.block("sine", "controller")


def test_pages_and_examples_import_no_private_module():
    pages = [*ROOT.glob("docs/*.md"), *ROOT.glob("examples/*.py"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    private = re.compile(r"^\s*(?:from|import) leadscrew\S*\._", re.MULTILINE)
    assert [page.name for page in pages if private.search(page.read_text(encoding="utf-8"))] == []


MINE = '''
from typing import NamedTuple
from leadscrew.kernel.block import controller

class MineParams(NamedTuple):
    """Gain."""
    kp: float = 3.0

@controller(MineParams())
def mine(p, command, feedback):
    """My own."""
    return p.kp * (command - feedback)

number = 3
'''


def test_an_installed_package_joins(tmp_path, monkeypatch):
    (tmp_path / "my_blocks.py").write_text(MINE)
    info = tmp_path / "my_blocks-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: my-blocks\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[leadscrew.blocks]\nmine = my_blocks:mine\ngone = my_blocks:gone\nnumber = my_blocks:number\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    assert resolve.block("mine").params.kp == 3.0
    assert "mine" in catalogue.block_names() and "mine" not in catalogue.study_names()
    with pytest.raises(LeadscrewError, match=r"plug-in 'gone' .*cannot be loaded"):
        resolve.block("gone")
    with pytest.raises(BlockError, match="is not a block but an object of type int"):
        resolve.block("number")
    with pytest.raises(NameUnknown, match="mine"):
        resolve.block("miner")


def test_a_block_of_ones_own_file(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(MINE)
    assert resolve.block(f"{path}:mine").params.kp == 3.0
    with pytest.raises(NameUnknown, match="did you mean mine"):
        resolve.block(f"{path}:mines")
    with pytest.raises(NameUnknown, match=r"it has .*mine"):
        resolve.block(str(path))
    with pytest.raises(BlockError, match="is not a block but an object of type int"):
        resolve.block(f"{path}:number")
    with pytest.raises(BlockError, match="not a study"):
        resolve.study(f"{path}:mine")
    with pytest.raises(DataError, match="there is no file"):
        resolve.block(f"{tmp_path}/none.py:mine")


def test_a_file_that_does_not_load_is_refused_with_its_line(tmp_path):
    path = tmp_path / "bad.py"
    for text, words in (
        ("x = 1\ny = (", "bad.py:2 does not load: SyntaxError"),
        ("\n\n1 / 0", "bad.py:3 .*ZeroDivision"),
    ):
        path.write_text(text)
        with pytest.raises(DataError, match=words):
            resolve.block(f"{path}:x")


def test_a_file_may_import_what_lies_beside_it_and_is_read_anew_when_changed(tmp_path):
    (tmp_path / "gains_beside_mine.py").write_text("KP = 5.0\n")
    path = tmp_path / "mine.py"
    path.write_text("from gains_beside_mine import KP\n" + MINE.replace("3.0", "KP"))
    assert resolve.block(f"{path}:mine").params.kp == 5.0
    path.write_text(MINE.replace("3.0", "4.0"))
    assert resolve.block(f"{path}:mine").params.kp == 4.0


def test_names_of_files_are_told_from_others():
    assert names.is_reference("a/b.py:c") and names.is_reference("b.py") and names.is_reference(r"C:\b.py:c")
    assert not names.is_reference("sine") and not names.is_reference("b.toml")
    assert names.absolute("sine") == "sine"
