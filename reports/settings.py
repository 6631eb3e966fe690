"""The manifest as lists that a person reads: of each part its settings by name, problems as scenes that can be pasted back."""

import json
from typing import Any, NamedTuple

from frictionbench.reports.drawing.text import scene_title
from frictionbench.results.conventions import DEFAULT_SCHEME

LONG = 160  # characters, beyond which a setting is folded
MOST = 20_000  # characters shown of one setting


class Setting(NamedTuple):
    """One line: its name, its value as text, and how many entries it lists where it is long, else 0."""

    name: str
    text: str
    entries: int


def settings(manifest: dict[str, Any]) -> list[tuple[str, list[Setting]]]:
    """The parts of the manifest that are objects, but for the solvers' words, then what stands alone, as the part "run"."""
    parts = [(part, values) for part, values in manifest.items() if isinstance(values, dict) and part != "solvers"]
    alone = {name: value for name, value in manifest.items() if not isinstance(value, dict)}
    return [(part, [_setting(part, *item) for item in values.items()]) for part, values in [*parts, ("run", alone)] if values]


def crowded(manifest: dict[str, Any]) -> int:
    """The workers of a run that left its main process no core of its own; 0 where one was left, or nothing says so."""
    machine = manifest.get("machine")
    workers, cores = manifest.get("workers"), machine.get("cores") if isinstance(machine, dict) else None
    return workers if isinstance(workers, int) and isinstance(cores, int) and workers >= cores else 0


def _setting(part: str, name: str, value: Any) -> Setting:
    text = _bytes(value) if name in ("memory", "memory_limit") else _told(value)
    shown = name if part == "versions" else name.replace("_", " ")
    return Setting(shown, text[:MOST], len(value) if isinstance(value, list) and len(text) > LONG else 0)


def _bytes(value: Any) -> str:
    return f"{value / 2**30:.3g} GiB" if isinstance(value, int | float) else _told(value)


def _told(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(_told, value)) or "none"
    if isinstance(value, dict):
        if isinstance(value.get("scene"), str) and "x" not in value:
            return _source(value)
        if isinstance(value.get("name"), str):
            return value["name"]
        return ", ".join(f"{name} {_told(entry)}" for name, entry in value.items())
    if isinstance(value, float):
        return f"{value:g}"
    return "none" if value is None else str(value)


def _source(value: dict[str, Any]) -> str:
    """A source of problems or a simulation: the scene, and how much of its motion where it is not the first step."""
    told = scene_title(value["scene"], json.dumps(value.get("parameters") or {}))
    told += f" from {value['file']}" if value.get("file") else ""
    told += f", {value['pick']} steps of its motion" if value.get("pick") else ""
    told += f", {value['steps']} steps long" if value.get("steps") else ""
    return told + (f" by {value['scheme']}" if value.get("scheme") not in (None, "", DEFAULT_SCHEME) else "")
