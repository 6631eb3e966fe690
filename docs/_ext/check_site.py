"""Check a built site: every link inside it leads somewhere, and no page loads anything from elsewhere.

python docs/_ext/check_site.py docs/_build/html
"""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {"script": "src", "img": "src", "iframe": "src", "source": "src", "link": "href"}
RELATIONS = ("stylesheet", "icon", "preload", "preconnect", "dns-prefetch")  # of <link>, which a browser follows by itself


class Page(HTMLParser):
    """The ids of a page, where its links lead, and what it loads."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        attributes = {name: value or "" for name, value in attrs}
        self.ids |= {attributes["id"]} if "id" in attributes else set()
        if tag == "a" and "href" in attributes:
            self.links.append(attributes["href"])
        if (name := LOADED.get(tag)) in attributes and (
            tag != "link" or set(attributes.get("rel", "").split()) & set(RELATIONS)
        ):
            self.loads.append(attributes[str(name)])


def faults(site: Path) -> list[str]:
    """A line for each link that leads nowhere and for each file that a page would fetch from elsewhere."""
    pages = {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}
    texts = []
    for path, page in pages.items():
        name = path.relative_to(site.resolve())
        texts += [f"{name}: loads {target}" for target in page.loads if remote(target)]
        for link in [*page.links, *page.loads]:
            parts = urlsplit(link)
            if remote(link) or parts.scheme:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                texts.append(f"{name}: {link} does not exist")
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].ids:
                texts.append(f"{name}: {link} has no such place")
    texts += [f"{path.relative_to(site)}: a style fetches from elsewhere" for path in site.rglob("*.css") if fetches(path)]
    return texts


def remote(target: str) -> bool:
    return target.startswith("//") or urlsplit(target).scheme in ("http", "https")


def fetches(style: Path) -> bool:
    text = style.read_text(encoding="utf-8")
    return any(start in text for start in ('url("http', "url(http", "url('http", '@import "http', "url(//"))


if __name__ == "__main__":
    told = faults(Path(sys.argv[1]))
    print("\n".join(told) or "all links inside the site hold, and it loads nothing from elsewhere")
    sys.exit(bool(told))
