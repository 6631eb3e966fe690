"""docs/fairness.md, made from the registry: what is done to every solver that is not ours, in the words of its own file.

    python -m frictionbench.harness.commands.fairness > docs/fairness.md

The docstring of an outside solver's file says what the page needs under the names of FIELDS, a colon after each; what the
contract and the packages said of it, where everything was installed, stands in docs/outside.tsv (harness.commands.outcomes).
"""

import csv
import re
import sys
from itertools import groupby

from frictionbench.harness.machine import PACKAGE
from frictionbench.solvers import SolverInfo, available, find

OUTCOMES = PACKAGE.parent / "docs" / "outside.tsv"
FIELDS = ("Licence", "Form", "Clock", "Tolerance", "Flaws", "Reference")
HEAD = """# Fairness

Made from the registry by `python -m frictionbench.harness.commands.fairness`; a test compares the two.

Every solver meets the same problems under the same clock, limit and verifier. Three times are measured apart: *form*, the
problem written as what the method takes; *setup*, the method's or library's own; *solve*. Their sum counts. A library that
keeps a clock of its own is shown with both. One thread, one core; loading and compiling are in no sample, in no limit. What a
solver claims decides nothing: the residual is computed again from the impulses. `tol` is a bound of the residual of the
solver's own model (problems.residual); each entry says how its own tolerances were set from it, with eps = tol as its scaled
problem has it. Versions: `frictionbench list solvers`.

The contract is `frictionbench check-solver NAME`: fifteen checks of form, honesty, edge cases and invariance. What each
solver breaks, with the first complaint, is recorded in docs/outside.tsv by
`python -m frictionbench.harness.commands.outcomes`, and so is what its package says of its licence. A solver of a relaxation or
of soft contacts is held to its own model there.

**To dispute an entry**: open an issue with a problem file (`frictionbench export`, or any that `frictionbench solve` reads) and
what the entry should do with it, or a pull request for its file, which is under 80 lines; the figures are then made again.
"""


def page() -> str:
    """The page, with every outside solver in the order of their names, and ours in a table."""
    known = sorted(available().items())
    ours = [
        f"| `{name}` | {info.model} | {_numbers(info.dimension)} | {'yes' if info.warm_start else 'no'} | {info.summary} |"
        for name, info in known
        if not info.needs and info.ours
    ]
    told = outcomes()
    parts = [
        HEAD,
        *(_entry(info, told) for _, info in known if info.needs and info.ours),
    ]
    table = ["| solver | model | dimension | warm start | |", "|---|---|---|---|---|", *ours]
    return "\n".join([*parts, "## Ours (BSD-3-Clause)", "", *table, ""])


def outcomes() -> dict[str, dict[str, str]]:
    """The recorded table's line of each entry."""
    with OUTCOMES.open(encoding="utf-8", newline="") as file:
        return {line["entry"]: line for line in csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE)}


def facts(info: SolverInfo) -> dict[str, str]:
    """What the file of a solver says under each of FIELDS."""
    text = sys.modules[info.make.__module__].__doc__ or ""
    found = re.findall(rf"^({'|'.join(FIELDS)}): (.*?)(?=^\w+: |\Z|^$)", text, flags=re.MULTILINE | re.DOTALL)
    return {name: " ".join(words.split()) for name, words in found}


def _entry(info: SolverInfo, told: dict[str, dict[str, str]]) -> str:
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
        *_contract(info.specs, told),
        "",
    ]
    return "\n".join(lines)


def _contract(specs: tuple[str, ...], told: dict[str, dict[str, str]]) -> list[str]:
    """What the packages and the contract said, entries of the same outcome together."""
    known = [told[spec] for spec in specs if spec in told]
    if not known:
        return []
    lines = [
        f"* Its packages say of their licence: {_each(known, 'licences', '; ')}.",
        f"* Contract, {known[0]['day']}, with {_each(known, 'versions', ', ')}:",
    ]
    for broken, same in groupby(sorted(known, key=lambda line: line["broken"]), key=lambda line: line["broken"]):
        names = ", ".join(f"`{line['entry']}`" for line in same)
        lines.append(f"    * {names}: {'keeps all of it' if broken == 'none' else _told(broken)}")
    return lines


def _each(lines: list[dict[str, str]], column: str, between: str) -> str:
    """The parts of a column, each once."""
    return between.join(dict.fromkeys(part for line in lines for part in line[column].split(between)))


def _told(broken: str) -> str:
    return broken if broken.startswith("not here") else f"breaks {broken}"


def _numbers(values: tuple[int, ...]) -> str:
    return ", ".join(map(str, values))


if __name__ == "__main__":
    sys.stdout.write(page())
