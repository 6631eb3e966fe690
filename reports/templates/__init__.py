"""The page's template and how it writes numbers; everything it is given is escaped unless it is our own markup."""

import json
import math
from base64 import b64encode
from hashlib import sha256
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from frictionbench.reports.drawing.text import power, seconds


def script(name: str) -> tuple[Markup, str]:
    """A script of this folder, and the hash by which a page's security policy lets it run, and no other."""
    text = Path(__file__).with_name(name).read_text(encoding="utf-8")
    return Markup(text), b64encode(sha256(text.encode()).digest()).decode()


def as_json(value: Any) -> Markup:
    """JSON that ends no script element, whatever text is in it."""
    return Markup(json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"))


def environment() -> Environment:
    """Templates with escaping on, and the filters that numbers pass through; "–" stands for what was not measured."""
    made = Environment(
        loader=PackageLoader("frictionbench.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {
        "seconds": lambda value: "–" if _absent(value) else seconds(value),
        "residual": lambda value: "–" if _absent(value) else _residual(value),
        "digits": lambda value: "–" if _absent(value) else _residual(value, 1),
        "power": power,
        "share": lambda value: "–" if _absent(value) else f"{math.floor(100 * value + 1e-9)} %",
        "percent": lambda value: "–" if _absent(value) else f"{100 * value:.{'2g' if abs(value) < 0.995 else '0f'}} %",
        "permille": lambda value: "–" if _absent(value) else f"{math.floor(1000 * value + 1e-9) / 10:g} %",
        "whole": lambda value: "–" if _absent(value) else f"{value:.0f}",
        "breakable": lambda name: Markup("_<wbr>").join(str(name).split("_")),
        "records": lambda table: table.to_dict("records"),
    }
    return made


def _absent(value: Any) -> bool:
    return value is None or (isinstance(value, float) and math.isnan(value))


def _residual(value: float, decimals: int = 0) -> str:
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    digit, exponent = f"{value:.{decimals}e}".split("e")
    return f"{digit}e{int(exponent)}"
