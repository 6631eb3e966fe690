"""Engines on phenomena with solutions in closed form; `python -m tools.battery` writes the tables of docs/battery.md."""
