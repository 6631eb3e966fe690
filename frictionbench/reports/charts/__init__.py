"""The charts of page and paper by name, in the order in which they are shown."""

from frictionbench.reports.charts import (
    convergence,
    energy,
    failure_maps,
    growth,
    pareto,
    profiles,
    speed_accuracy,
    stability,
    steps,
)

MAPS = (failure_maps.VERDICTS, failure_maps.TYPES, failure_maps.TIMES)
_ABOVE = (stability.CHART, *MAPS, pareto.CHART, speed_accuracy.CHART, convergence.CHART)
_BELOW = (profiles.CHART, profiles.WORK, profiles.WITHIN, growth.CHART, steps.CHART, energy.CHART)
CHARTS = {chart.name: chart for chart in (*_ABOVE, *_BELOW)}
