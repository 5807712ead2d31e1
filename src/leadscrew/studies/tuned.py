"""Gains that a search found: controller files of ``leadscrew tune``, in the folder ``tuned`` of a study.

``[set]`` holds the parameters, ``[tuning]`` how they were found: ``command`` finds them again.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from leadscrew import controller_file
from leadscrew.kernel.block import Block
from leadscrew.kernel.parameters import checked_replace

FOLDER = "tuned"


def tuned(folder: Path, name: str, block: Block, doc: str = "") -> Block:
    """A block with the parameters of ``folder/tuned/name.toml``.

    Raises:
        DataError, NameUnknown, ValueRefused: no such file, or parameters that the block does not have or refuses.
    """
    file = folder / FOLDER / f"{name}.toml"
    params = checked_replace(block.params, controller_file.read(file).parameters, where=f"{file}, [set]")
    return replace(block, params=params, doc=doc or block.doc)
