"""Phenomena with closed forms, on which engines are measured: `python -m tools.battery` writes the table of docs/battery.md."""
