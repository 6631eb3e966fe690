"""Loops over vectors, which compile much faster than numpy's expressions with their broadcasting and error handling."""

from frictionbench.problems.compiled import lean, lean_kernel


@lean
def put(v, u):  # type: ignore[no-untyped-def]
    """v = u."""
    for i in range(len(v)):
        v[i] = u[i]


@lean
def fill(v, value):  # type: ignore[no-untyped-def]
    """Every entry of v = value."""
    for i in range(len(v)):
        v[i] = value


@lean_kernel
def least(v, count):  # type: ignore[no-untyped-def]
    """The least of the first `count` entries of v, NaN if one is NaN."""
    smallest = v[0]
    for i in range(count):
        if not v[i] >= smallest:
            smallest = v[i]
    return smallest


@lean
def largest(v, count):  # type: ignore[no-untyped-def]
    """The largest of the first `count` entries of v, NaN if one is NaN."""
    most = v[0]
    for i in range(count):
        if not v[i] <= most:
            most = v[i]
    return most
