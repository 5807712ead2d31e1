"""Array parameters and states of the lanes: every array lies lane after lane in one long vector."""


def copy_lane(target, source, start, size, lane, width):
    """Copies one array into one lane."""
    for e in range(size):
        target[start * width + lane * size + e] = source[start + e]
    return 0


def set_lane(target, start, size, place, lane, width, value):
    """Sets one element of one array in one lane, where ``place`` falls into the array."""
    if place >= start and place < start + size:
        target[start * width + lane * size + place - start] = value
    return 0


def sound1(a):
    """Whether every element is finite."""
    sound = True
    for i in range(a.shape[0]):
        sound = sound & (abs(a[i]) <= 1.7976931348623157e308)
    return sound
