"""What the tests of exports share with those of the command line."""

from tests.cli.conftest import call, refused

__all__ = ["call", "refused"]
