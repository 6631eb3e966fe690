"""Names with settings, as the command line and rows write them: `stack[blocks=5,friction=0.5]`, `nsgs[relaxation=1.3]`."""

import re

from frictionbench.problems.check import InputError


def split(field: str, text: str) -> tuple[str, dict[str, str | None]]:
    """The name and its settings as text, None where one has no `=`. Errors: InputError naming the field."""
    match = re.fullmatch(r"\s*([\w.-]+)\s*(?:\[(.*)\])?\s*", text)
    if match is None:
        raise InputError(f"{field}: cannot read {text!r}; write name or name[setting=value,...]")
    name, settings = match.groups()
    pairs = [[part.strip() for part in setting.partition("=")] for setting in filter(None, (settings or "").split(","))]
    return name, {key: value if equals else None for key, equals, value in pairs}
