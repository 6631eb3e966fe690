"""The environment of the templates and the format of numbers in them. All text is escaped, except markup of this package."""

import json
import math
from base64 import b64encode
from hashlib import sha256
from itertools import count as numbers
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from frictionbench.reports.accuracy import LEAST_FOR_P99, shown_levels
from frictionbench.reports.drawing import tiles
from frictionbench.reports.drawing.figures import distinct, inline_svg, swatch
from frictionbench.reports.drawing.style import Look
from frictionbench.reports.drawing.text import percent, plain, power, ratio, residual, rough_percent, seconds
from frictionbench.results.commands import rerun
from frictionbench.results.conventions import ENDINGS, count, ending, scene_title
from frictionbench.results.files import write_text
from frictionbench.results.hardness import HARDNESS


def as_json(value: Any) -> Markup:
    """Return the value as JSON that cannot end a script element."""
    return Markup(json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"))


def environment(*folders: Path) -> Environment:
    """Return an environment for the templates in this folder and others, with escaping and with filters for numbers, commands
    and drawings. A missing number is shown as "–"."""
    loader = FileSystemLoader([Path(__file__).parent, *folders])
    made = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    drawings = numbers()
    made.filters |= {function.__name__: function for function in (power, ratio, count, ending)}
    made.filters |= {
        "seconds3": lambda value: "–" if pd.isna(value) else "∞" if math.isinf(value) else seconds(value, 3),
        "seconds": lambda value: "–" if pd.isna(value) else seconds(value),
        "residual": lambda value: "–" if pd.isna(value) else residual(value),
        "digits": lambda value: "–" if pd.isna(value) else residual(value, 1),
        "levels": shown_levels,
        "share": lambda value: "–" if pd.isna(value) else percent(value),
        "percent": lambda value: "–" if pd.isna(value) else rough_percent(value),
        "permille": lambda value: "–" if pd.isna(value) else percent(value, 1),
        "whole": lambda value: "–" if pd.isna(value) else f"{value:.0f}",
        "breakable": lambda name, after="_": Markup(f"{after}<wbr>").join(str(name).split(after)),
        "records": lambda table: table.to_dict("records"),
        "rerun": lambda row, run: rerun(run.folder, row["key"], row["variant"], run.plugins),
        "scene": lambda row: scene_title(row["scene"], row["parameters"]),
        "svg": lambda drawn: Markup(distinct(swatch(drawn) if isinstance(drawn, Look) else inline_svg(drawn), next(drawings))),
        "paths": tiles.paths,
        "short": lambda name: plain(name, tiles.LONGEST_TITLE),
        "json": as_json,
    }

    def script(*names: str) -> tuple[Markup, str]:
        """Return the named scripts joined into one, and the hash by which a page's policy allows only this script."""
        text = "".join(loader.get_source(made, name)[0] for name in names)
        return Markup(text), b64encode(sha256(text.encode()).digest()).decode()

    made.globals |= {"endings": ENDINGS, "hardness": HARDNESS, "script": script, "p99_from": LEAST_FOR_P99}
    return made


def write_page(path: Path, template: str, **values: Any) -> Path:
    """Write a page made from a template in this folder; return its path."""
    write_text(path, environment().get_template(template).render(values))
    return path
