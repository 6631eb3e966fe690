"""docs/fairness.md, made from the registry: what is done to every solver that is not ours, in the words of its own file.

    python -m harness.commands.fairness > docs/fairness.md

The docstring of an outside solver's file says what the page needs under the names of FIELDS, a colon after each.
"""

import re
import sys

from solvers import SolverInfo, available, find

FIELDS = ("Licence", "Form", "Clock", "Tolerance", "Flaws", "Reference")
HEAD = """# Fairness

Made from the registry by `python -m harness.commands.fairness`; a test compares the two.

Every solver meets the same problems under the same clock, limit and verifier. Three times are measured apart: *form*, the
problem written as what the method takes; *setup*, the method's or library's own; *solve*. Their sum counts. A library that
keeps a clock of its own is shown with both. One thread, one core; loading and compiling are in no sample, in no limit. What a
solver claims decides nothing: the residual is computed again from the impulses. `tol` is a bound of the residual of the
solver's own model (problems.residual); each entry says how its own tolerances were set from it, with eps = tol as its scaled
problem has it. Versions: `frictionbench list solvers`. The contract: `frictionbench check-solver NAME`.

**To dispute an entry**: open an issue with a problem file (`frictionbench export`, or any that `frictionbench solve` reads) and
what the entry should do with it, or a pull request for its file, which is under 80 lines; the figures are then made again.
"""


def page() -> str:
    """The page, with every outside solver in the order of their names, and ours in a table."""
    known = sorted(available().items())
    ours = [
        f"| `{name}` | {info.model} | {_numbers(info.dimension)} | {'yes' if info.warm_start else 'no'} | {info.summary} |"
        for name, info in known
        if not info.needs and info.make.__module__.startswith("solvers.")
    ]
    parts = [HEAD, *(_entry(info) for _, info in known if info.needs and info.make.__module__.startswith("solvers."))]
    table = ["| solver | model | dimension | warm start | |", "|---|---|---|---|---|", *ours]
    return "\n".join([*parts, "## Ours (BSD-3-Clause)", "", *table, ""])


def facts(info: SolverInfo) -> dict[str, str]:
    """What the file of a solver says under each of FIELDS."""
    text = sys.modules[info.make.__module__].__doc__ or ""
    found = re.findall(rf"^({'|'.join(FIELDS)}): (.*?)(?=^\w+: |\Z|^$)", text, flags=re.MULTILINE | re.DOTALL)
    return {name: " ".join(words.split()) for name, words in found}


def _entry(info: SolverInfo) -> str:
    said = facts(info)
    models = sorted({find(spec)[0].model for spec in info.specs})
    dimensions = tuple(sorted({d for spec in info.specs for d in find(spec)[0].dimension}))
    needs = sorted({need for spec in info.specs for need in find(spec)[0].needs})
    lines = [
        f"## {info.name}",
        "",
        info.summary,
        "",
        f"* Entries: {', '.join(f'`{spec}`' for spec in info.specs)}",
        f"* Needs: {', '.join(needs)}",
        f"* Model: {', '.join(models)}; dimension {_numbers(dimensions)}",
        *(f"* {name}: {said[name]}" for name in FIELDS if name in said),
        "",
    ]
    return "\n".join(lines)


def _numbers(values: tuple[int, ...]) -> str:
    return ", ".join(map(str, values))


if __name__ == "__main__":
    sys.stdout.write(page())
