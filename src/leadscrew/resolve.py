"""From a name to what it means: a block, a study, a controller of a study; the only place that decides by the form of a
name.

==================================  ===================================================================================
``pid``, ``vud_lathe``              of the catalogue, or of an installed plug-in
``path/file.py:name``               an object in a file of the user's
``rules.fis`` (fll, fcl, xml)       a controller: a fuzzy system, ``:name`` its output
``tuned.toml``                      a controller with its parameters, as ``leadscrew tune`` writes it
``machine.toml``                    the study of an axis, as ``leadscrew identify axis`` writes it
==================================  ===================================================================================
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew import catalogue, controller_file, names, userfile
from leadscrew.kernel.parameters import checked_replace, nearest
from leadscrew.util.errors import BlockError, CodeNotTrusted, DataError, LeadscrewError, NameUnknown, entry_point

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.study_data import Study

_fuzzy: dict[tuple[Path, str, str | None, str, str], Any] = {}
"""Controllers of fuzzy systems, by file, digest, output and fields."""


@entry_point
def block(name: str, kind: str | None = None) -> Block:
    """The block of a name.

    Raises:
        NameUnknown: no such block; names the nearest.
        BlockError: what is there is not a block, or not of that ``kind``.
        DataError: the file is missing or does not load.
        CodeNotTrusted: a file names it, and it may not run.
        ValueRefused: a fuzzy system that cannot be a controller; says why.
    """
    from leadscrew.kernel.block import Block

    if names.is_toml(name):
        value = from_controller_file(name)
    else:
        value = load(name) if names.is_reference(name) else catalogue.block(name)
    if not isinstance(value, Block):
        raise BlockError(
            f"{name} is not a block but an object of type {type(value).__name__}; decorate its step: @controller(...)"
        )
    if kind is not None and value.kind != kind:
        raise BlockError(f"{name} is a {value.kind}, not a {kind}")
    return value


@entry_point
def study(name: str) -> Study:
    """The study of a name.

    Raises:
        NameUnknown: no such study; names the nearest.
        BlockError: what is there is not a study.
        DataError: the file is missing or does not load.
    """
    from leadscrew.study_data import Study

    value = subject(name)
    if not isinstance(value, Study):
        raise BlockError(f"{name} is not a study but an object of type {type(value).__name__}")
    return value


def subject(name: str) -> Any:
    """The study of a name, or what else stands under it in a file of the user's: a loop, a function.

    Raises: as :func:`study`, but BlockError.
    """
    if names.is_toml(name):
        from leadscrew.machine.axis_study import study as machine

        return machine(name)
    return load(name) if names.is_reference(name) else catalogue.study(name)


def load(reference: str) -> Any:
    """The object that ``path/file.py:name`` names; of a fuzzy system's file the controller, ``name`` its output.

    Raises: as :func:`block`.
    """
    return fuzzy_controller(reference) if names.is_fuzzy_file(reference) else userfile.load(reference)


def controller(study: Study, name: str) -> Block:
    """A controller of the study by its name there, or any other controller by name.

    The file of a fuzzy system makes a controller for the study's machine: what its output commands, and in which unit,
    stands in no such file, so it is what the study's own controllers agree on.

    Raises:
        NameUnknown: none of these. Else as :func:`block`.
    """
    if name in study.controllers:
        return study.controllers[name]
    if names.is_toml(name):
        return from_controller_file(name, study)
    if names.is_fuzzy_file(name):
        return replace(block(name, "controller"), **machine_of(study))
    if names.is_reference(name) or name in catalogue.block_names():
        return block(name, "controller")
    known = [*study.controllers, *catalogue.block_names()]
    raise NameUnknown(f"{study.name} has no controller {name!r}{nearest(name, known)}")


def machine_of(study: Study) -> dict[str, Any]:
    """What all controllers of a study say of the machine."""
    keys = ("unit", "drive", "full_scale", "sense")
    values = {tuple(getattr(block, key) for key in keys) for block in study.controllers.values()}
    return dict(zip(keys, next(iter(values)), strict=True)) if len(values) == 1 else {}


def from_controller_file(path: str | Path, of: Study | None = None) -> Block:
    """The controller of a file with its parameters, for a study; for the file's own unless given.

    Raises:
        DataError: the file is malformed, or its parameters do not fit the controller; names file and key.
        CodeNotTrusted: it names Python that may not run.
    """
    file = controller_file.read(path)
    try:
        base = controller(of or study(file.study), file.controller)
        params = checked_replace(base.params, file.parameters, where="[set]")
    except CodeNotTrusted:
        raise
    except LeadscrewError as error:
        raise DataError(f"{path}: {error}") from error
    return replace(base, params=params)


def fuzzy_controller(reference: str, command: str = "", feedback: str = "") -> Any:
    """The controller of a fuzzy system's file, made once as long as the file stays as it is.

    ``command`` and ``feedback`` are the fields of these signals that it takes, where they have several.
    """
    from leadscrew.fuzzy.block import from_file

    path, output = names.parts(reference)
    path = path.expanduser()
    key = (path.resolve(), userfile.digest(path), output, command, feedback)
    if key not in _fuzzy:
        _fuzzy[key] = from_file(path, output, command=command, feedback=feedback)
    return _fuzzy[key]


def digests(*references: str | None) -> dict[str, str]:
    """SHA-256 of the files that are not Python, by path: of these no source stands in a manifest."""
    values: dict[str, str] = {}
    for reference in references:
        if reference is not None and (names.is_fuzzy_file(reference) or names.is_toml(reference)):
            path, _ = names.parts(names.absolute(reference))
            values[str(path)] = userfile.digest(path)
            if names.is_toml(reference):
                values |= digests(_base(path))
    return values


def _base(path: Path) -> str | None:
    """The controller that a controller file changes; none where it cannot be read."""
    try:
        return controller_file.read(path).controller
    except DataError:
        return None
