"""The charts of page and paper, one file each, in the order in which they are shown."""

from reports.charts import energy, growth, profiles, speed_accuracy

CHARTS = (speed_accuracy.CHART, profiles.CHART, growth.CHART, energy.CHART)
