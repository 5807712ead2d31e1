"""From export to a moving axis: every command of the page, in the real LinuxCNC, with the output that it shows."""

import shutil

import pytest

from leadscrew.export import hal_run
from tests.docs import sessions
from tests.docs.snippets import ROOT
from tests.tools import missing

PAGE = ROOT / "docs" / "moving_axis.md"
AS_NOBODY = """chown -R {0}:{0} .
exec unshare --net setpriv --reuid={0} --regid={0} --clear-groups env -i PATH=/usr/bin:/bin HOME="$PWD" {1} "$@\""""


@pytest.mark.slow
def test_every_command_of_the_page_does_what_it_shows():
    why = hal_run.lacking()
    if why:
        missing("linuxcnc", why)
    tools = {"sudo": 'exec "$@"', "linuxcnc": AS_NOBODY.format(hal_run.NOBODY, shutil.which("linuxcnc"))}
    with hal_run.workplace() as place:
        folder = place / "page"
        folder.mkdir()
        script = sessions.prepare(PAGE, folder, tools)
        settings = [f"CLONE={ROOT}", f"RTAPI_UID={hal_run.NOBODY}", f"RTAPI_FIFO_PATH={place}/fifo/rtapi"]
        _, printed = hal_run.apart(place, ["env", *settings, "bash", str(script)], 300.0, folder)
    sessions.compare(PAGE, printed)


def test_the_page_shows_what_it_types():
    steps = sessions.steps_of(PAGE)
    assert len(steps) >= 15
    assert sum(bool(s.shown) for s in steps) >= 9
    assert len(sessions.files_of(PAGE)) == 2
