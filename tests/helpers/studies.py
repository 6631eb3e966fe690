"""Studies at reduced size: their tables computed in the test process, their texts filled in and their figures drawn."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from studies import running
from studies.study import Tables


def reduced(name: str, **arguments: Mapping[str, Any]) -> Tables:
    """The tables of a study, computed with these arguments by table."""
    return {rows.__name__: pd.DataFrame(rows(**arguments.get(rows.__name__, {}))) for rows in running.study(name).rows}


def text(name: str, tables: Tables) -> dict[str, str]:
    """The study's text, of which every figure can be drawn and every number is one."""
    summary = running.study(name).summary(tables)
    found = running.text(name, summary)
    lines = [line for line in found["body"].splitlines() if not line.startswith("|")]
    assert "nan" not in " ".join(lines).split()
    for figure, panels in summary.figures.items():
        assert f"{name}_{figure}.svg" in found["body"]
        for panel in panels:
            ax = Figure().subplots()
            panel.draw(ax)
            legend = ax.get_legend()
            assert legend is None or legend.get_window_extent().x0 >= ax.get_window_extent().x1  # it hides no curve
    return found | {"body": " ".join(found["body"].split())}
