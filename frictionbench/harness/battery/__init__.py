"""Phenomena with closed forms, on which engines are measured: error against the closed form, for several steps.

python -m frictionbench.harness.battery.table > docs/battery.md
"""
