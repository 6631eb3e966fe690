"""The charts of page and paper, one file each, in the order in which they are shown."""

from frictionbench.reports.charts import (
    budget,
    classes,
    convergence,
    energy,
    forces,
    growth,
    maps,
    pareto,
    profiles,
    speed_accuracy,
    stability,
    work,
)

MAPS = (maps.VERDICTS, maps.TYPES, maps.TIMES, maps.WORK)
CHARTS = (
    *(stability.CHART, forces.CHART, *MAPS, pareto.CHART, speed_accuracy.CHART, convergence.CHART),
    *(profiles.CHART, work.CHART, budget.CHART, classes.CHART, growth.CHART, energy.CHART),
)
