"""``leadscrew list``: blocks, studies, and what can be set in them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.options import Json, Trust
from leadscrew.cli.output import deliver
from leadscrew.cli.subject import study_of

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.study_data import Study


def is_controller(name: str) -> bool:
    """Whether a name means a controller file.

    Raises:
        DataError: no such file, or bad TOML.
    """
    from leadscrew import toml_file

    return name.endswith(".toml") and toml_file.read(Path(name).expanduser()).get("kind") == "controller"


def list_(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]",
            help="A block, a study, path/file.py:NAME, a fuzzy system's file, "
            "or a controller, machine or experiment file (.toml).",
        ),
    ] = None,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """List blocks and studies; with a name, everything that can be set in it."""
    from leadscrew.report import listing
    from leadscrew.study_data import Study

    if name is None:
        report = listing.everything()
    elif is_controller(name):
        report = listing.controller(name)
    else:
        found = _found(name)
        report = listing.study(found) if isinstance(found, Study) else listing.block(name, found)
    deliver(report, as_json=as_json)


def _found(name: str) -> Study | Block:
    """The study or block of a name.

    Raises:
        LeadscrewError: there is neither.
    """
    from leadscrew import catalogue, experiment, names, resolve
    from leadscrew.kernel.parameters import nearest
    from leadscrew.study_data import Study
    from leadscrew.util.errors import NameUnknown

    if experiment.is_file(name):
        return study_of(name)
    if names.is_reference(name):
        found = resolve.load(name)
        return found if isinstance(found, Study) else resolve.block(name)
    if name in catalogue.study_names():
        return resolve.study(name)
    if name in catalogue.block_names() or name in catalogue.FACTORIES:
        return resolve.block(name)
    known = [*catalogue.study_names(), *catalogue.block_names()]
    raise NameUnknown(f"there is no block or study {name!r}{nearest(name, known)}")
