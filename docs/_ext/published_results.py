"""What published runs say.

`published-results` is a table of them all, `published-answer SUITE` the fastest solver for each kind of problem in the newest
of a suite, `published-headlines` the sentences of the newest of each suite, `published-ranks KIND` the places of the solvers of
`standard` in the newest of each suite.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from frictionbench.reports.drawing.text import count, power, seconds
from frictionbench.results import RankBy
from tools.publish.site import Entry, write_site
from tools.publish.summary import Summary, read

SUMMARIES = Path(__file__).parents[2] / "results" / "published"
HEADS = ("suite", "version", "machine", "finished", "ranked problems")


def entries() -> list[Entry]:
    """The published runs, the newest first."""
    found = [Entry(read(path)) for path in SUMMARIES.glob("*.json")]
    return sorted(found, key=lambda entry: (entry.summary["finished"], entry.summary["name"]), reverse=True)


def link(entry: Entry, text: str) -> nodes.paragraph:
    address = f"published/{entry.page}#{entry.summary['name']}"
    return nodes.paragraph("", "", nodes.reference("", text, refuri=address, internal=True))


def table(heads: Sequence[str], lines: Iterable[nodes.row]) -> nodes.table:
    made, group = nodes.table(), nodes.tgroup(cols=len(heads))
    group.extend(nodes.colspec(colwidth=1) for _ in heads)
    group += nodes.thead("", row([nodes.paragraph(text=head) for head in heads]))
    group += nodes.tbody("", *lines)
    made += group
    return made


class OfSummaries(SphinxDirective):
    """A directive whose page is read again when summaries come or go."""

    def run(self) -> list[nodes.Node]:
        self.env.note_dependency(str(SUMMARIES))
        return self.made(entries())

    def made(self, found: list[Entry]) -> list[nodes.Node]:
        raise NotImplementedError


class PublishedResults(OfSummaries):
    def made(self, found: list[Entry]) -> list[nodes.Node]:
        return [table(HEADS, map(self.line, found))]

    def line(self, entry: Entry) -> nodes.row:
        s = entry.summary
        machine = f"{s['machine'].get('processor')}, {count(s['machine'].get('cores'), 'core')}"
        texts = (f"{s['release']} {s['version']}".strip(), machine, s["finished"][:10], str(s["problems"]["ranked"]))
        return row([link(entry, s["suite"]), *(nodes.paragraph(text=text) for text in texts)])


def row(cells: list[nodes.Node]) -> nodes.row:
    return nodes.row("", *(nodes.entry("", cell) for cell in cells))


class PublishedAnswer(OfSummaries):
    required_arguments = 1

    def made(self, found: list[Entry]) -> list[nodes.Node]:
        entry = next((one for one in found if one.summary["suite"] == self.arguments[0]), None)
        if entry is None:
            return []
        rows = entry.summary["rankings"]
        finest = min(one["target"] for one in rows)
        firsts = {(one["kind"], one["by"]): one for one in reversed(rows) if one["target"] == finest}
        kinds = dict.fromkeys(one["kind"] for one in rows)
        heads = (f"problems, to {power(finest)}", *(f"fastest {by.words}" for by in RankBy))
        lines = [
            row([nodes.paragraph(text=kind), *(nodes.paragraph(text=first(firsts.get((kind, by.value)))) for by in RankBy)])
            for kind in kinds
        ]
        s = entry.summary
        said = f"Suite {s['suite']}, version {s['version']}, {s['machine'].get('processor')}, {s['finished'][:10]}"
        return [table(heads, lines), link(entry, said)]


def first(found: Summary | None) -> str:
    """The first of a kind: its mean and how many problems it solved, or why there is no winner."""
    if found is None or found["unclear"]:
        return found["unclear"] if found else "none"
    return f"{found['solver']} {seconds(found['mean'])} ({found['reached']}/{found['problems']})"


class PublishedHeadlines(OfSummaries):
    def made(self, found: list[Entry]) -> list[nodes.Node]:
        told: list[nodes.Node] = []
        for suite, entry in newest(found).items():
            if entry.summary["headline"]:
                told.append(link(entry, suite))
                items = [nodes.list_item("", nodes.paragraph(text=line)) for line in entry.summary["headline"]]
                told.append(nodes.bullet_list("", *items))
        return told


def newest(found: list[Entry]) -> dict[str, Entry]:
    """By suite its newest run."""
    return {entry.summary["suite"]: entry for entry in reversed(found)}


class PublishedRanks(OfSummaries):
    """By solver its place and the problems that it solved, from bodies and to the finest tolerance, in a column a suite."""

    required_arguments = 1
    final_argument_whitespace = True

    def made(self, found: list[Entry]) -> list[nodes.Node]:
        places: dict[str, dict[str, str]] = {}
        for suite, entry in newest(found).items():
            rows = [
                one for one in entry.summary["rankings"] if (one["kind"], one["by"]) == (self.arguments[0], RankBy.BODIES.value)
            ]
            finest = min((one["target"] for one in rows), default=None)
            ranked = [one for one in rows if one["target"] == finest and not one["law"]]
            places[suite] = {
                one["solver"]: f"{place} ({one['reached']}/{one['problems']})" for place, one in enumerate(ranked, start=1)
            }
        first = places.pop("standard", {})
        others = {suite: own for suite, own in sorted(places.items()) if first.keys() & own.keys()}
        lines = [
            row([nodes.paragraph(text=text) for text in (solver, place, *(own.get(solver, "–") for own in others.values()))])
            for solver, place in first.items()
        ]
        return [table(("solver", "standard", *others), lines)] if lines else []


def write_pages(app: Any) -> None:
    site = Path(app.srcdir) / "_build" / "extra" / "published"
    write_site(entries(), site)


def setup(app: Any) -> dict[str, bool]:
    app.add_directive("published-results", PublishedResults)
    app.add_directive("published-answer", PublishedAnswer)
    app.add_directive("published-headlines", PublishedHeadlines)
    app.add_directive("published-ranks", PublishedRanks)
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True}
