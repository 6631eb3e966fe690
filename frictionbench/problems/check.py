"""Checks of input data and of the parameters of scenes. Every error names its field."""

from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionbench.problems.rows import Rows, from_dense, from_matrix

Array = NDArray[np.float64]
LARGEST_COUNT = 10**8  # the largest count: no machine holds a larger problem
LARGEST_FLOAT = int(np.finfo(float).max)  # to compare with integers of any size, which float() may not take
REAL = "fiu"  # numpy's kinds of real numbers: floats, integers with and without sign


class InputError(ValueError):
    """A field of a problem, scene or setting that cannot be used; the message begins with the field's name.

    >>> import frictionbench as fb
    >>> try:
    ...     fb.LCP([[1.0]], [0.0, 1.0])
    ... except fb.InputError as error:
    ...     print(error)
    M: expected shape (2, 2), got (1, 1)
    """


class ReadOnly:
    """Copies by pickle or copy.deepcopy are read-only like the original, although numpy makes copied arrays writeable."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, part in state.items():
            set_read_only(part)
            object.__setattr__(self, name, part)


def set_read_only(value: Any) -> None:
    """Make arrays read-only, also in tuples and sparse matrices. All problems need the same, as kernels depend on it."""
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
    elif isinstance(value, tuple):
        for part in value:
            set_read_only(part)
    elif sparse.issparse(value):
        set_read_only((value.data, value.indices, value.indptr))


def require(condition: bool, field: str, reason: str) -> None:
    """Raise InputError for `field` unless the condition holds."""
    if not condition:
        raise InputError(f"{field}: {reason}")


def require_installed(module: str, extra: str) -> None:
    """Errors: InputError naming the module, if it is missing, and the command that installs the extra to which it belongs."""
    require(find_spec(module) is not None, module, f"not installed; pip install 'frictionbench[{extra}]'")


def number(name: str, value: Any, above: float = -np.inf, least: float = -np.inf, most: float = np.inf) -> float:
    """A finite number with above < value, least <= value <= most. Errors: InputError naming the parameter."""
    if not isinstance(value, (int, float, np.integer, np.floating)) or isinstance(value, bool):
        raise InputError(f"{name}: expected a finite number, got {value!r:.100}")
    if -np.inf < value < np.inf and abs(int(value)) <= LARGEST_FLOAT and above < value and least <= value <= most:
        return float(value)
    bounds = ("above", above), ("at least", least), ("at most", most)
    limits = [f"{word} {bound:g}" for word, bound in bounds if np.isfinite(bound)]
    raise InputError(f"{name}: must be {' and '.join(['finite', *limits])}, got {value!r:.100}")


def count(name: str, value: Any, least: int = 1) -> int:
    """An integer from `least` to LARGEST_COUNT. Errors: InputError naming the parameter."""
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    require(whole, name, f"expected an integer, got {value!r:.100}")
    require(value >= least, name, f"must be at least {least}, got {value!r:.100}")
    require(value <= LARGEST_COUNT, name, f"must be at most {LARGEST_COUNT}, got {value!r:.100}")
    return int(value)


def counted(number: int, noun: str) -> str:
    """The number with its noun in the singular or plural: 1 contact, 12 contacts, 3 bodies."""
    plural = noun[:-1] + "ies" if noun.endswith("y") else noun + "s"
    return f"{number} {noun if number == 1 else plural}"


def vector(field: str, value: Any, length: int | None = None) -> Array:
    """A read-only float vector of the given length (any, if None) with finite entries."""
    array = floats(field, value)
    require(array.ndim == 1, field, f"expected a vector, got shape {array.shape}")
    require(length is None or len(array) == length, field, f"expected length {length}, got {len(array)}")
    require_finite(field, array)
    array.setflags(write=False)
    return array


def entries(field: str, array: Array, expected: int) -> Array:
    """The array, flattened. Errors: InputError naming the field if it does not have `expected` entries.

    The number of entries is checked here because compiled loops do not check bounds.
    """
    flat = _real(field, array).ravel()
    if len(flat) != expected:
        raise InputError(f"{field}: expected {expected} entries, got {len(flat)}")
    return flat


def rows(field: str, value: Any, shape: tuple[int | None, int]) -> Rows:
    """A checked matrix by rows (problems.rows), accepted in any form that `matrix` accepts.

    Rows are canonical, because only this package makes them, so only their number and their entries are checked.
    Errors: InputError naming the field.
    """
    if sparse.issparse(value):
        return from_matrix(matrix(field, value, shape))
    if not isinstance(value, Rows):
        array = _real(field, value)
        _require_shape(field, array, shape)
        require_finite(field, array)
        return from_dense(array)
    require(shape[0] in (None, len(value.start) - 1), field, f"expected {_show(shape)}, got {len(value.start) - 1} rows")
    require_finite(field, value.value)
    return value


def matrix(field: str, value: Any, shape: tuple[int | None, int | None]) -> sparse.csr_array:
    """A canonical sparse matrix (rows sorted, duplicates summed, no stored zeros) with finite entries."""
    if sparse.issparse(value):
        require(value.dtype.kind in REAL, field, f"not a matrix of real numbers, but of {value.dtype}")
        require_consistent(field, value)
    else:
        value = floats(field, value)
    _require_shape(field, value, shape)
    result = sparse.csr_array(value, dtype=np.float64, copy=True)
    require_finite(field, result.data, result)
    result.sum_duplicates()
    result.eliminate_zeros()
    for part in (result.data, result.indices, result.indptr):
        part.setflags(write=False)
    return result


def _require_shape(field: str, value: Any, shape: tuple[int | None, int | None]) -> None:
    require(value.ndim == 2, field, f"expected a matrix, got shape {value.shape}")
    if any(expected not in (None, size) for size, expected in zip(value.shape, shape, strict=True)):
        raise InputError(f"{field}: expected shape {_show(shape)}, got {value.shape}")


def require_consistent(field: str, value: Any) -> None:
    """Refuse a sparse matrix whose arrays are inconsistent: SciPy's compiled code would read or write outside them."""
    try:
        if value.format in ("csr", "csc", "bsr"):
            start = value.indptr  # SciPy's own test uses differences, which may overflow
            require(bool((start[1:] >= start[:-1]).all()), field, "not a sparse matrix (its indptr decreases)")
            value.copy().check_format(full_check=True)  # on a copy, because check_format shortens arrays
        elif value.format == "coo":
            for index, size in zip(value.coords, value.shape, strict=True):
                require(len(index) == len(value.data), field, "as many indices as entries are needed")
                require(bool(((index >= 0) & (index < size)).all()), field, f"an index is not between 0 and {size - 1}")
    except InputError:
        raise
    except (ValueError, TypeError, IndexError, AttributeError) as error:
        raise InputError(f"{field}: not a sparse matrix ({error})") from None


def path(field: str, value: Any) -> Path:
    """The value as a path. Errors: InputError naming the field."""
    try:
        return Path(value)
    except TypeError:
        raise InputError(f"{field}: expected a path as text, got {value!r:.100}") from None


def floats(field: str, value: Any) -> Array:
    """A copy of the value as an array of floats, of any shape. Errors: InputError naming the field."""
    return np.array(_real(field, value))


def _real(field: str, value: Any) -> Array:
    """The value as an array of floats, without a copy if it is one.

    Only real numbers are converted. Complex numbers would lose their imaginary part and masked arrays their mask; text, truth
    values, dates and objects would become numbers that were not meant. Errors: InputError naming the field.
    """
    if type(value) is np.ndarray and value.dtype == np.float64:
        return value
    masked = any(map(np.ma.isMaskedArray, (value, *value) if isinstance(value, list | tuple) else (value,)))
    require(not masked, field, "is a masked array; fill it, or leave the masked entries out")
    require(not sparse.issparse(value), field, "is sparse; expected a dense array")
    try:
        array = np.asarray(value)
    except (TypeError, ValueError) as error:
        raise InputError(f"{field}: not an array of numbers ({error})") from None
    require(array.dtype.kind in REAL, field, f"not an array of real numbers, but of {array.dtype}")
    return np.asarray(array, dtype=np.float64)


def require_finite(field: str, values: Array, of: sparse.csr_array | None = None) -> None:
    """Errors: InputError naming the field and its first entry that is not finite. of: the sparse matrix with these values."""
    if np.isfinite(values).all():
        return
    bad = int(np.flatnonzero(~np.isfinite(values))[0])
    if of is None:
        place = bad if values.ndim == 1 else tuple(map(int, np.unravel_index(bad, values.shape)))
    else:
        place = tuple(int(axis[bad]) for axis in of.tocoo().coords)
    raise InputError(f"{field}: entry {place} is {values.flat[bad]}; all must be finite")


def _show(shape: tuple[int | None, int | None]) -> str:
    return "(" + ", ".join("any" if n is None else str(n) for n in shape) + ")"
