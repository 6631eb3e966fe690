"""The charts of page and paper, one file each, in the order in which they are shown."""

from reports.charts import classes, energy, growth, maps, pareto, profiles, speed_accuracy

MAPS = (maps.VERDICTS, maps.TYPES, maps.TIMES)
CHARTS = (pareto.CHART, *MAPS, speed_accuracy.CHART, profiles.CHART, classes.CHART, growth.CHART, energy.CHART)
