"""Measure the installed engines, and write the tables of docs/battery.md: errors against the closed forms by step size, and the
orders of convergence.

python -m tools.battery
"""

import re
import warnings
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from tools.battery import bullet, drake, mujoco, own, rapier
from tools.battery.phenomena import PHENOMENA, Phenomenon
from tools.battery.world import Make, Unsupported

STEPS = (0.008, 0.004, 0.002, 0.001)  # s
MOVING = tuple(f"| {name}" for name in ("stopping", "direction", "rebound, e = 0.5", "rebound, e = 1", "sliding", "box in"))
ERRORS = re.compile(" / ".join([r"(-?[\d.]+e[-+]\d+)(?: ± (\S+))?"] * len(STEPS)))  # in a cell of the table
ENGINES: dict[str, tuple[str, Make]] = {  # by name, the package needed and the engine
    "frictionbench": ("frictionbench", own.Exact),
    "MuJoCo": ("mujoco", mujoco.MuJoCo),
    "MuJoCo, stiff": ("mujoco", mujoco.stiff),
    "Drake": ("drake", drake.Drake),
    "Drake, SAP": ("drake", drake.sap),
    "Drake, CENIC": ("drake", drake.cenic),
    "Drake, margin": ("drake", drake.margin),
    "Drake, softer": ("drake", drake.softer),
    "Drake, stiff": ("drake", drake.stiff),
    "PyBullet, two settings changed": ("pybullet", bullet.Bullet),
    "PyBullet, stiff": ("pybullet", bullet.stiff),
    "Rapier": ("rapier3d", rapier.Rapier),
    "Rapier, stiff": ("rapier3d", rapier.stiff),
}
PAGE = Path(__file__).parents[2] / "docs" / "battery.md"
TABLE = re.compile(r"(?<=<!-- begin: python -m tools.battery -->\n).*?(?=<!-- end -->)", re.DOTALL)


def table() -> str:
    """Return the table in Markdown, and a line for each engine that is not installed."""
    usable, remarks = {}, []
    for name, (package, make) in ENGINES.items():
        try:
            engine, comma, settings = name.partition(",")
            usable[f"{engine} {version(package)}{comma}{settings}"] = make
        except PackageNotFoundError:
            remarks.append(f"\n{name}: skipped, it is not installed (`pip install {package}`).\n")
    rows = [["phenomenon", "closed form", "", *usable], ["---"] * 3 + ["--:"] * len(usable)]
    for one in PHENOMENA:
        closed = f"{one.formula}{f' = {one.exact:.4g}' if not one.formula.endswith('0') else ''}"
        rows.append([one.name, closed, one.unit, *(_errors(one, make) for make in usable.values())])
    return "".join([*(f"| {' | '.join(row)} |\n" for row in rows), *remarks])


def orders(made: str) -> str:
    """Return the rows of MOVING in `made` with the least-squares slope of log error over log step, for all steps and for the
    larger and the smaller half of them; a dash if signs differ, error bars reach 0, or all are below own.TOLERANCE."""
    kept = [line for line in made.splitlines() if line.startswith(("| phenomenon", "| ---", *MOVING))]
    return "\n" + "".join(f"{ERRORS.sub(_orders, line)}\n" for line in kept)


def _orders(cell: re.Match[str]) -> str:
    means, bars = (np.array(cell.groups("0")[k::2], dtype=float) for k in (0, 1))
    if abs(np.sign(means).sum()) < len(means) or (abs(means) <= bars).any() or abs(means).max() < own.TOLERANCE:
        return "–"
    x, y = np.log(STEPS), np.log(abs(means))
    whole, large, small = (np.polyfit(x[own], y[own], 1)[0].round(1) + 0.0 for own in (slice(None), slice(2), slice(-2, None)))
    return f"{whole:.1f} ({large:.1f}, {small:.1f})"


def _errors(one: Phenomenon, make: Make) -> str:
    errors = [_error(one, make, step) for step in STEPS]
    return "–" if set(errors) == {"–"} else " / ".join(errors)


def _error(one: Phenomenon, make: Make, step: float) -> str:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            off = np.atleast_1d(one.measure(make, step)) - one.exact
            return f"{off.mean():.1e}" if len(off) == 1 else f"{off.mean():.1e} ± {np.ptp(off) / 2:.0e}"
        except Unsupported:
            return "–"
        except (Exception, SystemExit) as error:  # whatever an engine raises is shown in its cell
            return f"failed: {type(error).__name__}"


if __name__ == "__main__":
    made = table()
    made += orders(made)
    PAGE.write_text(TABLE.sub(lambda _: made, PAGE.read_text(encoding="utf-8")), encoding="utf-8")
