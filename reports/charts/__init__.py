"""The charts of page and paper, one file each, in the order in which they are shown."""

from reports.charts import energy, growth, pareto, profiles, speed_accuracy

CHARTS = (pareto.CHART, speed_accuracy.CHART, profiles.CHART, growth.CHART, energy.CHART)
