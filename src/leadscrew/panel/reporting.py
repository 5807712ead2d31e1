"""A process of its own that makes the report of a session: the session file's text comes in, the HTML page goes out."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path


def main() -> int:
    """Exit code 2 and one sentence where it cannot be made.

    The session is the panel's own: the machine has run the Python that it names already.
    """
    from leadscrew.operate import session_file
    from leadscrew.report import session as session_report
    from leadscrew.userfile import trust
    from leadscrew.util.errors import LeadscrewError

    with tempfile.TemporaryDirectory() as beside:
        path = Path(beside) / "session.toml"
        path.write_text(sys.stdin.read(), encoding="utf-8")
        try:
            with trust():
                html = session_report.html(session_file.read(path))
        except LeadscrewError as error:
            print(error, file=sys.stderr)
            return 2
    sys.stdout.write(html)
    return 0


if __name__ == "__main__":
    sys.exit(main())
