"""Parsing a scene with settings, as written on the command line: `stack[blocks=5,friction=0.5]`."""

import json
from typing import Any

from frictionbench.problems import InputError
from frictionbench.problems.spec import split


def parse(field: str, text: str) -> tuple[str, dict[str, Any]]:
    """The name and its settings; numbers, true and false become values, anything else stays text.

    Errors: InputError naming the field.
    """
    name, settings = split(field, text)
    values: dict[str, Any] = {}
    for key, value in settings.items():
        if value is None or not key:
            raise InputError(f"{field}: cannot read the setting {key!r} of {name}; write setting=value")
        values[key] = _value(value)
    return name, values


def _value(text: str) -> Any:
    try:
        return json.loads(text.lower())
    except ValueError:
        return text
