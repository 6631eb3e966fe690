"""Measure the installed engines, and write the tables of docs/battery.md: errors against the closed forms by step size, and
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
ERROR = re.compile(r"(-?[\d.]+e[-+]\d+)(?: ± (\S+))?")
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


def sections() -> str:
    """Return Markdown: the engines' versions, those that are not installed, and a section for each phenomenon."""
    usable, versions, remarks = {}, {}, []
    for name, (package, make) in ENGINES.items():
        try:
            versions[name.partition(",")[0]] = version(package)
            usable[name] = make
        except PackageNotFoundError:
            remarks.append(f"\n{name}: skipped, it is not installed (`pip install {package}`).\n")
    made = [f"Versions: {', '.join(' '.join(one) for one in versions.items())}.\n", *remarks]
    return "".join([*made, *(section(one, usable) for one in PHENOMENA)])


def section(one: Phenomenon, usable: dict[str, Make]) -> str:
    """Return Markdown: what the phenomenon is, and a table of errors, engines by steps; with orders where a body moves at last,
    except for tipping, whose slope is bisected."""
    said = " ".join(str(getattr(one.measure, "func", one.measure).__doc__).split())
    value = f" = {one.exact:.4g} {one.unit}".rstrip() if one.exact else ""
    closed = f" Closed form: {one.formula}{value}." if one.formula else ""
    heading = f"{'error' if one.formula else 'time'}, {one.unit}".strip(", ")
    order = ["order"] if one.exact and one.unit else []
    rows = [[heading, *(f"{1000 * step:g} ms" for step in STEPS), *order], ["---"] + ["--:"] * len([*STEPS, *order])]
    for name, make in usable.items():
        errors = [_error(one, make, step) for step in STEPS]
        rows.append([name, *errors, *(order_of(errors) for _ in order)])
    table = "".join(f"| {' | '.join(row)} |\n" for row in rows)
    return f"\n### {one.name[0].upper()}{one.name[1:]}\n\n{said}{closed}\n\n{table}"


def order_of(errors: list[str]) -> str:
    """Return the least-squares slope of log error over log step, ± a bound of what the error bars can change in it, and in
    brackets the slopes of the larger and the smaller half of the steps; a dash if one is no number, signs differ, error bars
    reach 0, or all are below own.TOLERANCE."""
    read = [ERROR.fullmatch(error) for error in errors]
    means, bars = np.array([one.groups("0") if one else ("nan", "0") for one in read], dtype=float).T
    if abs(np.sign(means).sum()) != len(means) or (abs(means) <= bars).any() or abs(means).max() < own.TOLERANCE:
        return "–"
    x, y = np.log(STEPS), np.log(abs(means))
    whole, large, small = (np.polyfit(x[at], y[at], 1)[0].round(1) + 0.0 for at in (slice(None), slice(2), slice(-2, None)))
    most = abs(x - x.mean()) @ -np.log1p(-bars / abs(means)) / x.var() / len(x)
    return f"{whole:.1f} ± {most:.1f} ({large:.1f}, {small:.1f})"


def _error(one: Phenomenon, make: Make, step: float) -> str:
    with warnings.catch_warnings(action="ignore"):
        try:
            off = np.atleast_1d(one.measure(make, step)) - one.exact
            return f"{off.mean():.1e}" if len(off) == 1 else f"{off.mean():.1e} ± {np.ptp(off) / 2:.0e}"
        except Unsupported:
            return "–"
        except (Exception, SystemExit) as error:  # whatever an engine raises is shown in its cell
            return f"failed: {type(error).__name__}"


if __name__ == "__main__":
    made = sections()
    PAGE.write_text(TABLE.sub(lambda _: made, PAGE.read_text(encoding="utf-8")), encoding="utf-8")
