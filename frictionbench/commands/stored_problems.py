"""Whether a results folder, which may come from anybody, holds the problems that its rows name."""

from collections.abc import Iterable
from pathlib import Path

from frictionbench.harness.cells.collect import stored


def held(folder: Path, problems: Iterable[str]) -> tuple[bool, str]:
    """Whether each problem is stored with the hash that it is named by; and in words.

    Errors: InputError where a file holds another problem or is damaged.
    """
    named = sorted(set(problems) - {""})
    there = [name for name in named if (folder / "problems" / f"{name}.npz").exists()]
    for name in there:
        stored(folder, name)
    if len(there) == len(named):
        return True, f"The {len(named)} problems in the folder are those that the rows name, by their hashes."
    missing = len(named) - len(there)
    return False, f"{missing} of {len(named)} problems are not in the folder, so that their hashes were not checked."
