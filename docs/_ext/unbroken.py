"""An option in a command that is shown in a block is not broken after its hyphens, where the line is wrapped (wrap.css)."""

import re
from typing import Any

BLOCK, OPTION = re.compile(r"<pre>.*?</pre>", re.DOTALL), re.compile(r"(?<![^\s\[(])--?[a-z][\w-]*")


def keep_options(app: Any, name: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    def kept(block: re.Match[str]) -> str:
        return OPTION.sub(r'<span class="option">\g<0></span>', block[0])

    context["body"] = BLOCK.sub(kept, context.get("body", ""))


def setup(app: Any) -> dict[str, bool]:
    app.connect("html-page-context", keep_options)
    return {"parallel_read_safe": True}
