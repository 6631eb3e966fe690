"""The table of engines and phenomena, as a page of Markdown."""

import warnings
from importlib.metadata import PackageNotFoundError, version

from frictionbench.harness.battery import drake, mujoco
from frictionbench.harness.battery.phenomena import PHENOMENA, Phenomenon
from frictionbench.harness.battery.world import Make

STEPS = (0.004, 0.002, 0.001)  # s
ENGINES: dict[str, tuple[str, Make]] = {  # by name, what has to be installed, and the engine
    "MuJoCo": ("mujoco", mujoco.default),
    "MuJoCo, stiff": ("mujoco", mujoco.stiff),
    "Drake": ("drake", drake.default),
    "Drake, stiff": ("drake", drake.stiff),
}
PAGE = """# Engines on phenomena with closed forms

Made by `python -m frictionbench.harness.battery.table`, which measures the engines that are installed. Each cell has the error,
what the engine gave less the closed form, at steps of {steps} ms: an error that shrinks with the step is one of its time
stepping, one that does not is one of its model.

{table}
{remarks}
Scripts: `harness/battery/phenomena.py` has each phenomenon in some ten lines, `harness/battery/mujoco.py` and
`harness/battery/drake.py` how each engine builds them.

## What each phenomenon is

{phenomena}

## What the engines trade

Engines regularise contacts on purpose: a soft contact has an answer that is unique, can be differentiated and inverted, and
costs the same in every step. The columns *stiff* have much stiffer settings, of kinds that the documentation describes.

* **MuJoCo** is as it is by default: pyramidal cones, `impratio` 1, `solref` of 20 ms. A pyramid slows a box that is thrown
  askew along one of its axes first, so that its path bends; a soft contact creeps under a steady load in proportion to the
  load. *Stiff*: elliptic cones, `impratio` 100, `noslip_iterations`, `solref` of two steps, `solimp` .99. It has no
  coefficient of restitution; rebounds by `solref` are not measured here.
* **Drake** has contacts by surfaces (hydroelastic), with the default modulus of 1e7 Pa and the default approximation, kLagged.
  A surface with dissipation resists rolling, which a point does not: the ball's row contains that. *Stiff*: 1e9 Pa and the
  approximation kSimilar. It has no coefficient of restitution.

Bodies are put down at rest or with their speed, touching what they stand on: a compliant contact begins with an oscillation
that the closed forms do not have, and that the tipping box and the one on the slope can feel.

A body that sticks or rests has the same closed form for every step; one that moves has an error of the order of the step for
any first-order scheme: the box that stops misses v h/2, 4 mm at 4 ms, with exact contacts.
"""


def page() -> str:
    """The page."""
    usable, remarks = {}, []
    for name, (package, make) in ENGINES.items():
        try:
            engine, comma, settings = name.partition(",")
            usable[name] = (f"{engine} {version(package)}{comma}{settings}", make)
        except PackageNotFoundError:
            remarks.append(f"\n{name}: skipped, it is not installed (`pip install {package}`).\n")
    heads = ["phenomenon", "closed form", "", *(title for title, _ in usable.values())]
    rows = [heads, ["---"] * 3 + ["--:"] * len(usable)]
    for one in PHENOMENA:
        closed = f"{one.formula}{f' = {one.exact:.4g}' if not one.formula.endswith('0') else ''}"
        rows.append([one.name, closed, one.unit, *(_errors(one, make) for _, make in usable.values())])
    table = "\n".join(f"| {' | '.join(row)} |" for row in rows)
    steps = ", ".join(f"{1000 * step:g}" for step in STEPS)
    return PAGE.format(steps=steps, table=table, remarks="".join(remarks), phenomena=phenomena())


def phenomena() -> str:
    """What each phenomenon is, as a list."""
    return "\n".join(f"* **{one.name}**: {one.measure.__doc__}" for one in PHENOMENA)


def _errors(one: Phenomenon, make: Make) -> str:
    return " / ".join(_error(one, make, step) for step in STEPS)


def _error(one: Phenomenon, make: Make, step: float) -> str:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return f"{one.measure(make, step) - one.exact:.1e}"
        except (Exception, SystemExit) as error:  # whatever an engine raises is its cell
            return f"failed: {type(error).__name__}"


if __name__ == "__main__":
    print(page(), end="")
