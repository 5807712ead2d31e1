"""Which rules of a block fire: each takes the degrees of the rules and writes the ones that are left, others as 0.

Rules of equal degree are taken in their order.
"""

from __future__ import annotations

from leadscrew.kernel.guards import unguarded


@unguarded
def first(degrees, fired, count, threshold):
    """The first rules whose degree is above 0 and at least the threshold."""
    taken = 0
    for i in range(degrees.shape[0]):
        fires = taken < count and degrees[i] > 0.0 and degrees[i] >= threshold
        fired[i] = degrees[i] if fires else 0.0
        taken = taken + (1 if fires else 0)
    return 0


@unguarded
def last(degrees, fired, count, threshold):
    """The last rules whose degree is above 0 and at least the threshold."""
    taken = 0
    for k in range(degrees.shape[0]):
        i = degrees.shape[0] - 1 - k
        fires = taken < count and degrees[i] > 0.0 and degrees[i] >= threshold
        fired[i] = degrees[i] if fires else 0.0
        taken = taken + (1 if fires else 0)
    return 0


@unguarded
def highest(degrees, fired, count, threshold):
    """The rules of highest degree."""
    for _ in range(min(count, degrees.shape[0])):
        best, at = 0.0, 0
        for i in range(degrees.shape[0]):
            better = degrees[i] > best and fired[i] == 0.0
            at = i if better else at
            best = degrees[i] if better else best
        fired[at] = best if best > 0.0 else fired[at]
    return 0


@unguarded
def lowest(degrees, fired, count, threshold):
    """The rules of lowest degree above 0."""
    for _ in range(min(count, degrees.shape[0])):
        best, at, found = 0.0, 0, False
        for i in range(degrees.shape[0]):
            better = degrees[i] > 0.0 and fired[i] == 0.0 and (degrees[i] < best or not found)
            at = i if better else at
            best = degrees[i] if better else best
            found = found or better
        fired[at] = best if found else fired[at]
    return 0


@unguarded
def proportional(degrees, fired, count, threshold):
    """All rules, their degrees over the sum of all."""
    total = 0.0
    for i in range(degrees.shape[0]):
        total = total + degrees[i]
    for i in range(degrees.shape[0]):
        fired[i] = degrees[i] / (total if total > 0.0 else 1.0)
    return 0


@unguarded
def below(degrees, fired, count, threshold):
    """Rules whose degree is below the threshold."""
    for i in range(degrees.shape[0]):
        fired[i] = degrees[i] if degrees[i] < threshold else 0.0
    return 0


@unguarded
def at_most(degrees, fired, count, threshold):
    """Rules whose degree is at most the threshold."""
    for i in range(degrees.shape[0]):
        fired[i] = degrees[i] if degrees[i] <= threshold else 0.0
    return 0


@unguarded
def equal(degrees, fired, count, threshold):
    """Rules whose degree is the threshold."""
    for i in range(degrees.shape[0]):
        fired[i] = degrees[i] if degrees[i] == threshold else 0.0
    return 0


@unguarded
def other_than(degrees, fired, count, threshold):
    """Rules whose degree is not the threshold."""
    for i in range(degrees.shape[0]):
        fired[i] = degrees[i] if degrees[i] != threshold else 0.0
    return 0


@unguarded
def at_least(degrees, fired, count, threshold):
    """Rules whose degree is at least the threshold."""
    for i in range(degrees.shape[0]):
        fired[i] = degrees[i] if degrees[i] >= threshold else 0.0
    return 0


@unguarded
def above(degrees, fired, count, threshold):
    """Rules whose degree is above the threshold."""
    for i in range(degrees.shape[0]):
        fired[i] = degrees[i] if degrees[i] > threshold else 0.0
    return 0


METHODS = {"first": first, "last": last, "highest": highest, "lowest": lowest, "proportional": proportional}
THRESHOLDS = {"<": below, "<=": at_most, "==": equal, "!=": other_than, ">=": at_least, ">": above}
