"""docs/fairness.md, generated from the registry: how each outside solver is called, from the docstring of its file.

    python -m frictionbench.commands.fairness > docs/fairness.md

The docstring of an outside solver's file has the page's facts under the names of FIELDS, with a colon after each; Charged, why
an adapter is charged more than a call by hand (commands.charged), stands only where it is. The results of the contract
and the licences of the packages are in docs/outside.tsv (commands.outcomes).
"""

import csv
import re
import sys
from itertools import groupby
from operator import itemgetter

from frictionbench.problems.compiled import PACKAGE
from frictionbench.solvers import SolverInfo, available, find

OUTCOMES = PACKAGE.parent / "docs" / "outside.tsv"
FIELDS = ("Licence", "Form", "Clock", "Charged", "Settings", "Tolerance", "Flaws", "Reference")
HEAD = """# Fairness

Made from the registry by `python -m frictionbench.commands.fairness`; a test compares the two.

Every solver is given the same problems and timed with the same clock, limit and verification. Three times are measured
separately: *form*, writing the problem as the method takes it; *setup*, the method's or library's own; *solve*. Their sum is
compared. For a library with a clock of its own both times are shown. Solvers run in one thread on one core; loading and
compiling count neither as time nor towards the limit. Results are independently verified: the residual is computed from the
impulses, whatever status the solver reports. `tol` bounds the residual of the solver's own model (problems.residual); each
section states how the solver's own tolerances are set from it, with eps = tol in its scaled problem. Versions:
`frictionbench list solvers`.

The contract is `frictionbench check-solver NAME`: fifteen checks of the answer's format and status, degenerate problems and
invariance. The checks that each solver fails, with the first violation, and the licences in its packages' metadata are recorded
in docs/outside.tsv by `python -m frictionbench.commands.outcomes`. A solver of a relaxation or of regularised contacts
is checked against its own model.

`frictionbench fairness` times each adapter in turn with a call of its library by hand (harness/direct) at 2, 10 and 40
contacts; tests/solvers/outside/test_direct.py compares their answers. `frictionbench fairness --scene three_blocks` compares
what both claim on the steps of a scene: an inaccurate claim of an adapter is either the library's own, or a fault to report.
Its table is in docs/peers.md; where an adapter is charged more than 1.3 times a call by hand, its section below says why. A
library in another process (Siconos, GAMS' PATH) is compared by its own clock.

`default` and `tuned` are a library's options as a user gets them and as its documentation allows; tolerances and work limits
are set in both. Commands under *Settings* and *Flaws* show what is said there, and a test runs them.

Without an adapter: Kamino, in Newton 1.8, takes models, whose contacts it finds itself, in single precision, and no matrices;
MOSEK and Gurobi, for which no licence is at hand, and GAMS' licence forbids tables that have Gurobi beside PATH; jaxopt's
BoxCDQP, which runs with jax 0.10 on the program of `mujoco_boxqp` but traces it anew in each call, for 0.1 s and more.

**To dispute a section**: open an issue with a problem file (`frictionbench export`, or any that `frictionbench solve` reads)
and the result that the solver should give, or a pull request for its file, which is under 80 lines; the figures are then
computed again.
"""


def page() -> str:
    """The page: a section for every outside solver in alphabetical order, and our solvers in a table."""
    known = sorted(available().items())
    ours = [
        f"| `{name}` | {info.model} | {_numbers(info.dimension)} | {'yes' if info.warm_start else 'no'} | {info.summary} |"
        for name, info in known
        if not info.needs and info.ours
    ]
    results = outcomes()
    parts = [
        HEAD,
        *(_section(info, results) for _, info in known if info.needs and info.ours),
    ]
    table = ["| solver | model | dimension | warm start | |", "|---|---|---|---|---|", *ours]
    return "\n".join([*parts, "## Ours (BSD-3-Clause)", "", *table, ""])


def outcomes() -> dict[str, dict[str, str]]:
    """The recorded line of each variant."""
    with OUTCOMES.open(encoding="utf-8", newline="") as file:
        return {line["variant"]: line for line in csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE)}


def facts(info: SolverInfo) -> dict[str, str]:
    """The text under each of FIELDS in the docstring of a solver's file."""
    text = sys.modules[info.make.__module__].__doc__ or ""
    found = re.findall(rf"^({'|'.join(FIELDS)}): (.*?)(?=^\w+: |\Z|^$)", text, flags=re.MULTILINE | re.DOTALL)
    return {name: " ".join(words.split()) for name, words in found}


def _section(info: SolverInfo, results: dict[str, dict[str, str]]) -> str:
    stated = facts(info)
    models = sorted({find(spec)[0].model for spec in info.specs})
    dimensions = tuple(sorted({d for spec in info.specs for d in find(spec)[0].dimension}))
    needs = sorted({need for spec in info.specs for need in find(spec)[0].needs})
    lines = [
        f"## {info.name}",
        "",
        info.summary,
        "",
        f"* Variants: {', '.join(f'`{spec}`' for spec in info.specs)}",
        f"* Needs: {', '.join(needs)}",
        f"* Model: {', '.join(models)}; dimension {_numbers(dimensions)}",
        *(f"* {name}: {stated[name]}" for name in FIELDS if name in stated),
        *_contract(info.specs, results),
        "",
    ]
    return "\n".join(lines)


def _contract(specs: tuple[str, ...], results: dict[str, dict[str, str]]) -> list[str]:
    """The licences and the results of the contract, variants with the same result together."""
    known = [results[spec] for spec in specs if spec in results]
    if not known:
        return []
    lines = [
        f"* Licences in its packages' metadata: {_each(known, 'licences', '; ')}.",
        f"* Contract, {known[0]['date']}, with {_each(known, 'versions', ', ')}:",
    ]
    for failed, same in groupby(sorted(known, key=itemgetter("failed_checks")), key=itemgetter("failed_checks")):
        names = ", ".join(f"`{line['variant']}`" for line in same)
        lines.append(f"    * {names}: {'passes all checks' if failed == 'none' else _failures(failed)}")
    return lines


def _each(lines: list[dict[str, str]], column: str, between: str) -> str:
    """The parts of a column, each once."""
    return between.join(dict.fromkeys(part for line in lines for part in line[column].split(between)))


def _failures(failed: str) -> str:
    return failed if failed.endswith("not installed") else f"fails {failed}"


def _numbers(values: tuple[int, ...]) -> str:
    return ", ".join(map(str, values))


if __name__ == "__main__":
    sys.stdout.write(page())
