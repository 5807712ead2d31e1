"""A reader that asks for more memory than it may have."""


def apart(path, out):
    bytearray(100_000_000_000)
