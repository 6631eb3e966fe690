"""What published runs say.

`published-results` is a table of them all, `published-answer SUITE` the fastest solver for each kind of problem in the newest
of a suite, `published-headlines` the sentences of the newest of each suite, `published-ranks KIND` the places of the solvers of
`standard` in the newest of each suite, `published-leads` the leads of several runs of the same problems, by version.
"""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from frictionbench.reports.accuracy import OVERALL
from frictionbench.reports.drawing.text import power, seconds
from frictionbench.results.conventions import RankBy, count
from tools.publish.site import Entry, write_site
from tools.publish.summary import Summary, read

SUMMARIES = Path(__file__).parents[2] / "results" / "published"
HEADS = ("suite", "version", "machine", "finished", "ranked problems")


def entries() -> list[Entry]:
    """The published runs, the newest first."""
    read_entries = [Entry(read(path)) for path in SUMMARIES.glob("*.json")]
    return sorted(read_entries, key=lambda entry: (entry.summary["finished"], entry.summary["name"]), reverse=True)


def link(entry: Entry, text: str) -> nodes.paragraph:
    address = f"published/{entry.page}#{entry.summary['name']}"
    return nodes.paragraph("", "", nodes.reference("", text, refuri=address, internal=True))


def table(heads: Sequence[str], lines: Iterable[nodes.row]) -> nodes.table:
    whole, group = nodes.table(), nodes.tgroup(cols=len(heads))
    group.extend(nodes.colspec(colwidth=1) for _ in heads)
    group += nodes.thead("", row([nodes.paragraph(text=head) for head in heads]))
    group += nodes.tbody("", *lines)
    whole += group
    return whole


class OfSummaries(SphinxDirective):
    """A directive whose page is read again when summaries come or go."""

    def run(self) -> list[nodes.Node]:
        self.env.note_dependency(str(SUMMARIES))
        return self.body(entries())

    def body(self, published: list[Entry]) -> list[nodes.Node]:
        raise NotImplementedError


class PublishedResults(OfSummaries):
    def body(self, published: list[Entry]) -> list[nodes.Node]:
        return [table(HEADS, map(self.line, published))]

    def line(self, entry: Entry) -> nodes.row:
        s = entry.summary
        machine = f"{s['machine'].get('processor')}, {count(s['machine'].get('cores'), 'core')}"
        texts = (f"{s['release']} {s['version']}".strip(), machine, s["finished"][:10], str(s["problems"]["ranked"]))
        return row([link(entry, s["suite"]), *(nodes.paragraph(text=text) for text in texts)])


def row(cells: list[nodes.Node]) -> nodes.row:
    return nodes.row("", *(nodes.entry("", cell) for cell in cells))


class PublishedAnswer(OfSummaries):
    required_arguments = 1

    def body(self, published: list[Entry]) -> list[nodes.Node]:
        entry = next((one for one in published if one.summary["suite"] == self.arguments[0]), None)
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
        origin = f"Suite {s['suite']}, version {s['version']}, {s['machine'].get('processor')}, {s['finished'][:10]}"
        return [table(heads, lines), link(entry, origin)]


def first(place: Summary | None) -> str:
    """The first of a kind: its mean and how many problems it solved, or why there is no winner."""
    if place is None or place["unclear"]:
        return place["unclear"] if place else "none"
    return f"{place['solver']} {seconds(place['mean'])} ({place['reached']}/{place['problems']})"


class PublishedHeadlines(OfSummaries):
    def body(self, published: list[Entry]) -> list[nodes.Node]:
        parts: list[nodes.Node] = []
        for suite, entry in newest(published).items():
            if entry.summary["headline"]:
                parts.append(link(entry, suite))
                said = {line.partition(", ")[2]: line for line in entry.summary["headline"]}  # of robots alone, once
                items = [nodes.list_item("", nodes.paragraph(text=line)) for line in said.values()]
                parts.append(nodes.bullet_list("", *items))
        return parts


def newest(published: list[Entry]) -> dict[str, Entry]:
    """By suite its newest run."""
    return {entry.summary["suite"]: entry for entry in reversed(published)}


class PublishedRanks(OfSummaries):
    """By solver its place and the problems that it solved, from bodies and to the finest tolerance, in a column a suite."""

    required_arguments = 1
    final_argument_whitespace = True

    def body(self, published: list[Entry]) -> list[nodes.Node]:
        places: dict[str, dict[str, str]] = {}
        for suite, entry in newest(published).items():
            rows = [
                one for one in entry.summary["rankings"] if (one["kind"], one["by"]) == (self.arguments[0], RankBy.BODIES.value)
            ]
            finest = min((one["target"] for one in rows), default=None)
            ranked = [one for one in rows if one["target"] == finest and not one["law"]]
            places[suite] = {
                one["solver"]: f"{place} ({one['reached']}/{one['problems']})" for place, one in enumerate(ranked, start=1)
            }
        first = places.pop("standard", {})
        others = {suite: of_suite for suite, of_suite in sorted(places.items()) if first.keys() & of_suite.keys()}
        lines = [
            row(
                [
                    nodes.paragraph(text=text)
                    for text in (solver, place, *(of_suite.get(solver, "–") for of_suite in others.values()))
                ]
            )
            for solver, place in first.items()
        ]
        return [table(("solver", "standard", *others), lines)] if lines else []


class PublishedLeads(OfSummaries):
    """By suite with several runs of the same problems: in each run the newest run's first beside its next two, as lead says."""

    def body(self, published: list[Entry]) -> list[nodes.Node]:
        parts: list[nodes.Node] = []
        for suite, entry in newest(published).items():
            runs = [one for one in published if one.summary["suite"] == suite and same(one.summary, entry.summary)]
            orders = {where: [*means(entry.summary, where)][:3] for where in OVERALL.values()}
            compared = [(where, order[0], other) for where, order in orders.items() for other in order[1:]]
            if len(runs) > 1 and compared:
                heads = ("run", *(f"{first} over {other}, {where}" for where, first, other in compared))
                lines = [row([link(one, version(one, entry)), *(lead(one, *columns) for columns in compared)]) for one in runs]
                parts += [nodes.paragraph(text=suite), table(heads, lines)]
        return parts


def version(run: Entry, last: Entry) -> str:
    s = run.summary
    return f"{s['version'][:7]}, {s['finished'][:16].replace('T', ' ')}{', the newest' if run is last else ''}"


def lead(run: Entry, where: str, first: str, other: str) -> nodes.paragraph:
    """The mean of the other solver over that of the first. If they are the first two of this run, its interval follows, as its
    headline gives it, and whether it leaves the order undecided."""
    found = means(run.summary, where)
    if not {first, other} <= found.keys():
        return nodes.paragraph(text="–")
    text = f"{found[other] / found[first]:.2f}"
    if ends := interval(run.summary, where, first, other):
        text += f" ({' to '.join(ends)})" + ", undecided" * (float(ends[0]) <= 1)
    return nodes.paragraph(text=text)


def interval(run: Summary, where: str, first: str, other: str) -> tuple[str, ...]:
    """The ends of the interval of the lead from bodies, as the headline prints them; empty if these are not its two solvers. An
    end printed as 1.00 is undecided, since the samples give no further digit."""
    line = next((line for line in run["headline"] if re.match(f"{where}, \\d", line, re.IGNORECASE)), "")
    first, other = re.escape(first), re.escape(other)
    told = re.search(rf"from bodies {first} [^;]*? times ahead of {other} \(([\d.]+) to ([\d.]+)\)", line, re.IGNORECASE)
    return told.groups() if told else ()


def same(one: Summary, other: Summary) -> bool:
    """Whether two runs have the same problems, to the last bit, and one machine, of which a run may use some cores only."""
    machines = [{name: value for name, value in run["machine"].items() if name != "cores"} for run in (one, other)]
    return bool(one["problems"]["hashes"] == other["problems"]["hashes"] and machines[0] == machines[1])


def means(run: Summary, kind: str) -> dict[str, float]:
    """The mean times from bodies to the finest target by the solvers of Coulomb's law, the first first."""
    rows = [one for one in run["rankings"] if (one["kind"], one["by"]) == (kind, RankBy.BODIES.value) and not one["law"]]
    finest = min((one["target"] for one in rows), default=None)
    return {one["solver"]: one["mean"] for one in rows if one["target"] == finest and one["mean"]}


def write_pages(app: Any) -> None:
    site = Path(app.srcdir) / "_build" / "extra" / "published"
    write_site(entries(), site, "../published.html")


def setup(app: Any) -> dict[str, bool]:
    app.add_directive("published-results", PublishedResults)
    app.add_directive("published-answer", PublishedAnswer)
    app.add_directive("published-headlines", PublishedHeadlines)
    app.add_directive("published-ranks", PublishedRanks)
    app.add_directive("published-leads", PublishedLeads)
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True}
