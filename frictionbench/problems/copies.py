"""Independent copies of problems, for solvers that might modify what they are given."""

import copy
from typing import Any, TypeVar

import numpy as np
from scipy import sparse

from frictionbench.problems.forms.lcp import LCP, content_hash
from frictionbench.problems.friction import FrictionProblem

Problem = TypeVar("Problem", bound=FrictionProblem | LCP)


def duplicate(problem: Problem) -> Problem:
    """A deep copy of the problem without anything derived from it; changes to the copy do not affect the original.

    Arrays that are read-only in the original are read-only in the copy, because kernels are compiled for each kind of array.
    """
    return _copy_of_value(problem.fresh())


def nudged(problem: Problem, ulps: int) -> Problem:
    """A copy of the problem with every number multiplied by 1 + ulps * eps: larger by about ulps to 2 ulps last places."""
    return _copy_of_value(problem.fresh(), 1.0 + ulps * np.finfo(float).eps)


def same(one: FrictionProblem | LCP, other: FrictionProblem | LCP) -> bool:
    """Whether the two problems hold equal data, including the inverse mass derived from it."""
    return _digest(one) == _digest(other)


def _digest(problem: FrictionProblem | LCP) -> str:
    parts = {name: value if isinstance(value, tuple) else (value,) for name, value in vars(problem.fresh()).items()}
    return content_hash(**{f"{name} {k}": part for name, values in parts.items() for k, part in enumerate(values)})


def _copy_of_value(value: Any, factor: float = 1.0) -> Any:
    """A copy of the value, its real numbers multiplied by the factor."""
    if isinstance(value, np.ndarray):
        array = value * factor if value.dtype == float and factor != 1.0 else value.copy()
        array.setflags(write=value.flags.writeable)
        return array
    if isinstance(value, tuple) and hasattr(value, "_fields"):  # a matrix by rows
        return type(value)(*(_copy_of_value(part, factor) for part in value))
    if sparse.issparse(value):
        matrix = copy.copy(value)
        for part in ("data", "indices", "indptr"):
            setattr(matrix, part, _copy_of_value(getattr(value, part), factor))
        return matrix
    if hasattr(value, "__dict__"):  # a problem or its operator
        result = object.__new__(type(value))
        for name, part in vars(value).items():
            object.__setattr__(result, name, _copy_of_value(part, factor))
        return result
    return value
