"""The manifest as lists of named settings for a reader; problems are written as scenes that the command line accepts."""

import json
from typing import Any, NamedTuple

from frictionbench.results.conventions import DEFAULT_SCHEME, scene_title

LONG = 160  # characters, two lines of the page, above which a setting is folded
MOST = 20_000  # characters of one setting on the page; the manifest has all of it


class Setting(NamedTuple):
    """One line: a name, the value as text, and the number of items if it is a list to fold, else 0."""

    name: str
    text: str
    items: int


def settings(manifest: dict[str, Any]) -> list[tuple[str, list[Setting]]]:
    """The objects in the manifest except the descriptions of solvers, followed by its other values as the part `run`."""
    parts = [(part, values) for part, values in manifest.items() if isinstance(values, dict) and part != "solvers"]
    alone = {name: value for name, value in manifest.items() if not isinstance(value, dict)}
    return [(part, [_setting(part, *item) for item in values.items()]) for part, values in [*parts, ("run", alone)] if values]


def workers_on_all_cores(manifest: dict[str, Any]) -> int:
    """The number of workers if they left no core to the main process; 0 if one was left or the manifest does not state it."""
    workers, cores = manifest.get("workers"), manifest.get("machine", {}).get("cores")
    return workers if isinstance(workers, int) and isinstance(cores, int) and workers >= cores else 0


def _setting(part: str, name: str, value: Any) -> Setting:
    of_memory = name in ("memory", "memory_limit") and isinstance(value, int | float)
    text = f"{value / 2**30:.3g} GiB" if of_memory else _format(value)
    shown = name if part == "versions" else name.replace("_", " ")
    return Setting(shown, text[:MOST], len(value) if isinstance(value, list) and len(text) > LONG else 0)


def _format(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(_format, value)) or "none"
    if isinstance(value, dict):
        if isinstance(value.get("scene"), str) and "x" not in value:
            return _format_source(value)
        if isinstance(value.get("name"), str):
            return value["name"]
        return ", ".join(f"{name} {_format(item)}" for name, item in value.items())
    if isinstance(value, float):
        return f"{value:g}"
    return "none" if value is None else str(value)


def _format_source(value: dict[str, Any]) -> str:
    """A source of problems or a simulation: the scene, and which steps of its motion unless it is the first."""
    text = scene_title(value["scene"], json.dumps(value.get("parameters") or {}))
    text += f" from {value['file']}" if value.get("file") else ""
    text += f", {value['pick']} steps of its motion" if value.get("pick") else ""
    text += f", {value['steps']} steps long" if value.get("steps") else ""
    return text + (f" by {value['scheme']}" if value.get("scheme") not in (None, "", DEFAULT_SCHEME) else "")
