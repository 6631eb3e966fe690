"""A table of shares over two parameters, as coloured cells with their numbers."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.drawing.style import INK


def heat(ax: Axes, rows: pd.DataFrame, x: str, y: str, value: str) -> None:
    """Cells of the column `value` in [0, 1] over the columns x and y; a cell of 0 has no number."""
    table = rows.pivot_table(index=y, columns=x, values=value, sort=True)
    ax.imshow(100 * table.to_numpy(float), cmap="Blues", vmin=0, origin="lower", aspect="auto")
    dark = 0.6 * table.max().max()
    for (i, j), share in np.ndenumerate(table.to_numpy(float)):
        if share > 0:
            look: Any = {"ha": "center", "va": "center", "fontsize": "x-small", "color": "white" if share > dark else INK}
            ax.text(float(j), float(i), f"{100 * share:.2g}", **look)
    ax.set_xticks(range(table.shape[1]), [f"{at:.3g}" for at in table.columns])
    ax.set_yticks(range(table.shape[0]), [f"{at:.3g}" for at in table.index])
