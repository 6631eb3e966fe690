"""Links of pages that leave docs/, which hold on a code host: on the site they lead to the page that includes the file.

A link to a folder or file that is no page becomes its text.
"""

import re
from typing import Any

PAGES = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contribute.md",
    "SECURITY.md": "security.md",
    "CHANGELOG.md": "changes.md",
}


def on_site(match: re.Match[str]) -> str:
    text, target = match.groups()
    path, _, anchor = target.partition("#")
    if path in PAGES:
        return f"[{text}]({PAGES[path]}{'#' if anchor else ''}{anchor})"
    return text


def replace_links(app: Any, name: str, source: list[str]) -> None:
    if "/" not in name:  # of a page in docs/ itself; from the notebooks such a link leads to one
        source[0] = re.sub(r"\[([^\]]+)\]\(\.\./([^)\s]+)\)", on_site, source[0])


def setup(app: Any) -> dict[str, bool]:
    app.connect("source-read", replace_links)
    return {"parallel_read_safe": True}
