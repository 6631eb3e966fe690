"""The charts of page and paper, one file each, in the order in which they are shown."""

from frictionbench.reports.charts import (
    budget,
    classes,
    convergence,
    energy,
    failure_maps,
    forces,
    growth,
    pareto,
    profiles,
    speed_accuracy,
    stability,
    steps,
    work,
)

MAPS = (failure_maps.VERDICTS, failure_maps.TYPES, failure_maps.TIMES, failure_maps.WORK)
CHARTS = (
    *(stability.CHART, forces.CHART, *MAPS, pareto.CHART, speed_accuracy.CHART, convergence.CHART),
    *(profiles.CHART, work.CHART, budget.CHART, classes.CHART, growth.CHART, steps.CHART, energy.CHART),
)
