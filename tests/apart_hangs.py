"""A reader that does not come back."""

import time


def apart(path, out):
    time.sleep(60.0)
