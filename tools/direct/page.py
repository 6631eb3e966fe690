"""Make the sections of docs/fairness.md on how each outside solver is called, from the registry.

    python -m tools.direct.page      writes them into the page, after BEGIN

The docstring of an outside solver, or of its file, states the facts under the names of FIELDS, each followed by a colon.
Charged, why an adapter is charged more than a call by hand (tools.direct), is only present if it is. The law of solvers of the
relaxation is added here. The results of the contract and the licences of the packages are in docs/outside.tsv.
"""

import csv
import inspect
import re
import sys
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from textwrap import fill

from frictionbench.solvers import SolverInfo, available, find

DOCS = Path(__file__).parents[2] / "docs"
FIELDS = ("Licence", "Law", "Form", "Clock", "Charged", "Settings", "Tolerance", "Flaws", "Reference")
WIDTH = 125  # letters of a line
BOUND = "\N{NO-BREAK SPACE}"  # at which `fill` breaks no line
BEGIN = "<!-- begin: python -m tools.direct.page -->\n"


def page() -> str:
    """Return the page with current sections: one for every outside solver, and a table of our solvers."""
    known = sorted(available().items())
    ours = [
        f"| `{name}` | {info.model} | {_numbers(info.dimension)} | {'yes' if info.warm_start else 'no'} | {info.summary} |"
        for name, info in known
        if not info.needs and info.ours
    ]
    results = outcomes()
    prose = (DOCS / "fairness.md").read_text(encoding="utf-8").partition(BEGIN)[0]
    parts = [prose + BEGIN, *(_section(info, results) for _, info in known if info.needs and info.ours)]
    table = ["| solver | model | dimension | warm start | |", "|---|---|---|---|---|", *ours]
    return "\n".join([*parts, "## Ours (BSD-3-Clause)", "", *table, ""])


def outcomes() -> dict[str, dict[str, str]]:
    """Return the line of docs/outside.tsv for each variant."""
    with (DOCS / "outside.tsv").open(encoding="utf-8", newline="") as file:
        return {line["variant"]: line for line in csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE)}


def facts(info: SolverInfo) -> dict[str, str]:
    """Return the text under each of FIELDS in the docstring of a solver, or otherwise of its file."""
    found: dict[str, str] = {}
    for text in (sys.modules[info.make.__module__].__doc__ or "", inspect.getdoc(info.make) or ""):
        entries = re.findall(rf"^({'|'.join(FIELDS)}): (.*?)(?=^\w+: |\Z|^$)", text, flags=re.MULTILINE | re.DOTALL)
        found |= {name: " ".join(words.split()) for name, words in entries}
    if info.model == "relaxation":
        shown = f"`frictionbench solve stopping_block --solver {info.name}`"
        default = "by default " if any(find(spec)[0].model != info.model for spec in info.specs) else ""
        found["Law"] = f"{default}the convex relaxation, which by design differs from Coulomb's law where boxes slide, {shown}."
    return found


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
        f"* Model: {', '.join(models)}; dimension {_numbers(dimensions)}; {info.precision} precision",
        *(f"* {name}: {stated[name]}" for name in FIELDS if name in stated),
        *_contract(info.specs, results),
        "",
    ]
    return "\n".join(map(_wrapped, lines))


def _wrapped(line: str) -> str:
    """Break a line of Markdown, within its list item, at spaces outside of code."""
    mark = re.match(r"( *\* )?", line)[0]  # type: ignore[index]
    bound = re.sub("`[^`]*`", lambda code: code[0].replace(" ", BOUND), line)
    lines = fill(bound, WIDTH, subsequent_indent=" " * len(mark), break_long_words=False, break_on_hyphens=False)
    return lines.replace(BOUND, " ")


def _contract(specs: tuple[str, ...], results: dict[str, dict[str, str]]) -> list[str]:
    """Return the licences and the results of the contract, with variants of the same result merged."""
    known = [results[spec] for spec in specs if spec in results]
    if not known:
        return []
    lines = [
        f"* Licences in its packages' metadata: {_each(known, 'licences', '; ')}.",
        f"* Contract, {known[0]['date']}, with {_each(known, 'versions', ', ')}:",
    ]
    for failed, same in groupby(sorted(known, key=itemgetter("failed_checks")), key=itemgetter("failed_checks")):
        names = ", ".join(f"`{line['variant']}`" for line in same)
        told = failed if failed.endswith("not installed") else f"fails {failed}"
        lines.append(f"    * {names}: {'passes all checks' if failed == 'none' else told}")
    return lines


def _each(lines: list[dict[str, str]], column: str, between: str) -> str:
    """Return the distinct parts of a column."""
    return between.join(dict.fromkeys(part for line in lines for part in line[column].split(between)))


def _numbers(values: tuple[int, ...]) -> str:
    return ", ".join(map(str, values))


if __name__ == "__main__":
    (DOCS / "fairness.md").write_text(page(), encoding="utf-8")
