"""Edits of values, as someone makes who tries what a reader does with them: strange values, parts doubled or taken away."""

import os
from typing import Any

import numpy as np

CASES = int(os.environ.get("FRICTIONBENCH_MUTATIONS", "10"))  # more of them by hand
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
