"""What a written page consists of, as its HTML says."""

from base64 import b64encode
from collections import Counter, defaultdict
from hashlib import sha256
from html.parser import HTMLParser
from pathlib import Path


class Page(HTMLParser):
    """Tags by number, references, handlers of events, text outside scripts, and scripts by type."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.count: Counter[str] = Counter()
        self.references: list[str] = []
        self.handlers: list[str] = []
        self.text = ""
        self.scripts: defaultdict[str, list[str]] = defaultdict(list)
        self._inside: str | None = None
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        self.count[tag] += 1
        self.references += [value or "" for name, value in attrs if name.split(":")[-1] in ("href", "src")]
        self.handlers += [name for name, _ in attrs if name.startswith("on")]
        self._inside = dict(attrs).get("type", "") if tag == "script" else None

    def handle_endtag(self, tag):
        self._inside = None

    def handle_data(self, data):
        if self._inside is None:
            self.text += data
        else:
            self.scripts[self._inside].append(data)


def digest(script: str) -> str:
    """A script as the page's security policy names it."""
    return f"'sha256-{b64encode(sha256(script.encode()).digest()).decode()}'"


def with_more_script(path: Path, more: str, to: Path | None = None) -> None:
    """Write the page with more at the end of its script, which its security policy then allows."""
    (script,) = Page(path).scripts[""]
    text = path.read_text(encoding="utf-8").replace(script, script + more).replace(digest(script), digest(script + more))
    (to or path).write_text(text, encoding="utf-8")
