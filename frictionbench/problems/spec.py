"""Names with settings, as the command line and rows write them: `stack[blocks=5,friction=0.5]`, `nsgs[relaxation=1.3]`."""

import json
import re
from typing import Any

from frictionbench.problems.check import InputError, require

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")  # also those that JSON lacks, such as .5, 1. and +1


def split(field: str, text: str) -> tuple[str, dict[str, str | None]]:
    """The name and its settings as text; the value of a setting without `=` is None. Errors: InputError naming the field."""
    file, _, end = text.partition(".py[")
    require(field != "solver" or not end, field, f"settings belong to a solver; write --solver {file}.py --solver 'NAME[{end}'")
    match = re.fullmatch(r"\s*([\w.-]+)\s*(?:\[(.*)\])?\s*", text)
    if match is None:
        program = ", FILE.py or 'exec:./program {problem} {answer}'; repeat --solver for several" if field == "solver" else ""
        raise InputError(f"{field}: cannot read {text!r}; write name or name[setting=value,...]{program}")
    name, settings = match.groups()
    pairs = [[part.strip() for part in setting.partition("=")] for setting in filter(None, (settings or "").split(","))]
    found: dict[str, str | None] = {}
    for key, equals, value in pairs:
        require(key not in found, field, f"the setting {key!r} of {name} is given twice")
        found[key] = value if equals else None
    return name, found


def parse(field: str, text: str) -> tuple[str, dict[str, Any]]:
    """The name and its settings; numbers, true and false become values, anything else stays text.

    Errors: InputError naming the field.
    """
    name, settings = split(field, text)
    values: dict[str, Any] = {}
    for key, value in settings.items():
        if value is None or not key:
            raise InputError(f"{field}: cannot read the setting {key!r} of {name}; write setting=value")
        try:
            values[key] = json.loads(value.lower())
        except ValueError:
            values[key] = float(value) if _NUMBER.fullmatch(value) else value
    return name, values
