"""Edits of values, as someone makes who tries what a reader does with them: strange values, parts doubled or taken away."""

import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

CASES = int(os.environ.get("FRICTIONBENCH_MUTATIONS", "10"))
MOST_MEMORY = 500_000  # KiB
MOST_SECONDS = 10.0  # of processor time, which other processes on the machine do not change
STRANGE: list[Any] = [
    None,
    True,
    -1,
    0,
    2**70,
    1e308,
    float("nan"),
    float("inf"),
    "",
    "{",
    "../x",
    "\x00\x1b[31m",
    "ü" * 9,
    [],
    {},
]
STRANGE += [[[]], {"a": 1}, [1e308], "x" * 10**5, "\ud800", -(10**30), [None] * 9]


def edited(value: Any, random: np.random.Generator) -> Any:
    """The value with one part of it replaced, doubled or taken away."""
    if isinstance(value, dict) and value and random.random() < 0.9:
        name = list(value)[random.integers(len(value))]
        if random.random() < 0.2:
            return {key: part for key, part in value.items() if key != name}
        return value | {name: edited(value[name], random)}
    if isinstance(value, list) and value and random.random() < 0.8:
        i = int(random.integers(len(value)))
        return [*value[:i], edited(value[i], random), *value[i + (random.random() < 0.8) :]]
    return STRANGE[random.integers(len(STRANGE))]


def edited_array(array: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """The array with some of its entries, its length, its shape or its type changed."""
    kind, flat = random.integers(6), array.ravel().tolist()
    if kind == 0:
        return array.astype([str, bool, complex, "S3", object, np.float16, np.uint64, np.int8][random.integers(8)])
    if kind == 1:
        return array.reshape([(1, *array.shape), (*array.shape, 1), (-1,)][random.integers(3)])
    if kind == 2:
        return np.array(array.ravel()[: random.integers(array.size + 1)])
    values = [-(2**31), 2**31 - 1, -(2**63), 2**63 - 1, -1, 0, 1, 10**6, 1e308, -1e308, 5e-324, np.nan, np.inf]
    with np.errstate(all="ignore"):
        if not flat or kind == 3:
            return np.array([*flat, *flat, values[random.integers(len(values))]]).astype(array.dtype)
        changed = array.copy()
        for _ in range(random.integers(1, 3)):
            changed.flat[random.integers(array.size)] = np.array(values[random.integers(len(values))]).astype(array.dtype)
        return changed


def mutated(content: bytes, random: np.random.Generator) -> bytes:
    """A few bytes changed, a piece cut out, doubled, or moved."""
    data = bytearray(content)
    for _ in range(random.integers(1, 4)):
        a, b = sorted(random.integers(0, len(data), 2).tolist())
        kind = random.integers(4)
        if kind == 0:
            for i in random.integers(0, len(data), 8):
                data[i] = random.integers(256)
        elif kind == 1 and b - a < len(data) - 1:
            del data[a:b]
        elif kind == 2:
            data[a:a] = data[a : min(b, a + 1000)]
        else:
            data[a:b] = bytes(b - a)
    return bytes(data)


@contextmanager
def little_time() -> Iterator[None]:
    """Asserts that the block, with the processes that it starts and waits for, takes no more than MOST_SECONDS."""
    before = _processor_seconds()
    yield
    assert _processor_seconds() < before + MOST_SECONDS


def _processor_seconds() -> float:
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


@contextmanager
def little_memory() -> Iterator[None]:
    """Asserts that the block does not raise this process's peak of memory by more than MOST_MEMORY, nor that of the processes
    that it starts and waits for to more than that beyond its own, or than one of them had before."""
    own, children = (resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    yield
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < own + MOST_MEMORY
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss < max(children, own + MOST_MEMORY)
