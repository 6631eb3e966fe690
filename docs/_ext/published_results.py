"""The directives `published-results`, a table of all runs, and `published-headlines`, what the newest of each suite say."""

from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from frictionbench.reports.published.publish import publish
from frictionbench.reports.published.site import Entry
from frictionbench.results import summaries

SUMMARIES = Path(__file__).parents[2] / "results" / "published"
HEADS = ("suite", "version", "machine", "finished", "ranked problems")


def entries() -> list[Entry]:
    """The published runs, the newest first."""
    found = [Entry(summaries.read(path)) for path in SUMMARIES.glob("*.json")]
    return sorted(found, key=lambda entry: (entry.summary["finished"], entry.summary["name"]), reverse=True)


def link(entry: Entry, text: str) -> nodes.paragraph:
    address = f"published/{entry.page}#{entry.summary['name']}"
    return nodes.paragraph("", "", nodes.reference("", text, refuri=address, internal=True))


class PublishedResults(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        table, group = nodes.table(), nodes.tgroup(cols=len(HEADS))
        group.extend(nodes.colspec(colwidth=1) for _ in HEADS)
        group += nodes.thead("", row([nodes.paragraph(text=head) for head in HEADS]))
        group += nodes.tbody("", *map(self.line, entries()))
        table += group
        return [table]

    def line(self, entry: Entry) -> nodes.row:
        s = entry.summary
        machine = f"{s['machine'].get('processor')}, {s['machine'].get('cores')} cores"
        texts = (f"{s['release']} {s['version']}".strip(), machine, s["finished"][:10], str(s["problems"]["ranked"]))
        return row([link(entry, s["suite"]), *(nodes.paragraph(text=text) for text in texts)])


def row(cells: list[nodes.Node]) -> nodes.row:
    return nodes.row("", *(nodes.entry("", cell) for cell in cells))


class PublishedHeadlines(SphinxDirective):
    optional_arguments = 1  # a suite, else all

    def run(self) -> list[nodes.Node]:
        newest: dict[str, Entry] = {}
        for entry in entries():
            newest.setdefault(entry.summary["suite"], entry)
        found: list[nodes.Node] = []
        for suite, entry in newest.items():
            if entry.summary["headline"] and suite in (*self.arguments, suite)[:1]:
                found.append(link(entry, suite))
                items = [nodes.list_item("", nodes.paragraph(text=line)) for line in entry.summary["headline"]]
                found.append(nodes.bullet_list("", *items))
        return found


def write_pages(app: Any) -> None:
    site = Path(app.srcdir) / "_build" / "extra" / "published"
    list(publish([SUMMARIES], site, None, lambda folder, problems: (True, "")))


def setup(app: Any) -> dict[str, bool]:
    app.add_directive("published-results", PublishedResults)
    app.add_directive("published-headlines", PublishedHeadlines)
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True}
