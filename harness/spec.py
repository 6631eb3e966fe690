"""Names with settings, as the command line takes them: `stack[blocks=5,friction=0.5]`."""

import json
import re
from typing import Any

from problems import InputError


def parse(field: str, text: str) -> tuple[str, dict[str, Any]]:
    """The name and its settings; numbers and true/false are read as such, the rest as text.

    Errors: InputError naming the field.
    """
    match = re.fullmatch(r"\s*([\w.-]+)\s*(?:\[(.*)\])?\s*", text)
    if match is None:
        raise InputError(f"{field}: cannot read {text!r}; write name or name[setting=value,...]")
    name, settings = match.groups()
    values: dict[str, Any] = {}
    for setting in filter(None, (settings or "").split(",")):
        key, equals, value = (part.strip() for part in setting.partition("="))
        if not equals or not key:
            raise InputError(f"{field}: cannot read the setting {setting!r} of {name}; write setting=value")
        values[key] = _value(value)
    return name, values


def _value(text: str) -> Any:
    try:
        return json.loads(text.lower())
    except ValueError:
        return text
