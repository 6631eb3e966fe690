"""The table of engines and phenomena, as a page of Markdown."""

import warnings
from importlib.metadata import PackageNotFoundError, version

from frictionbench.harness.battery import bullet, drake, mujoco, own, rapier
from frictionbench.harness.battery.phenomena import PHENOMENA, Phenomenon
from frictionbench.harness.battery.world import Make, Unsupported

STEPS = (0.004, 0.002, 0.001)  # s
ENGINES: dict[str, tuple[str, Make]] = {  # by name, what has to be installed, and the engine
    "frictionbench": ("frictionbench", own.exact),
    "MuJoCo": ("mujoco", mujoco.default),
    "MuJoCo, stiff": ("mujoco", mujoco.stiff),
    "Drake": ("drake", drake.default),
    "Drake, margin": ("drake", drake.margin),
    "Drake, softer": ("drake", drake.softer),
    "Drake, stiff": ("drake", drake.stiff),
    "PyBullet": ("pybullet", bullet.default),
    "PyBullet, stiff": ("pybullet", bullet.stiff),
    "Rapier": ("rapier3d", rapier.default),
    "Rapier, stiff": ("rapier3d", rapier.stiff),
}
PAGE = """# Engines on phenomena with closed forms

Made by `python -m frictionbench.harness.battery.table`, which measures the engines that are installed. Each cell has the error,
what the engine gave less the closed form, at steps of {steps} ms. An error that shrinks with the step is one of its time
stepping; what another comes from, a model, a setting or a tolerance, is said below where it is known. Slopes of tipping are
bisected: 4e-4 is their resolution.

{table}
{remarks}
Scripts: `harness/battery/phenomena.py` has each phenomenon in some ten lines, `mujoco.py`, `drake.py`,
`bullet.py`, `rapier.py` and `own.py` beside it how each engine builds them. Most of them are scenes of this project too
(`sliding_box`, `box_tower`, `box_in_groove`, `sliding_ball`, `dropped_ball`), on which the suite `spatial` simulates every
solver in space; the column `path_error` has the distance from the closed form, and `frictionbench show` their motion.

## What each phenomenon is

{phenomena}

## What the engines trade

Engines regularise contacts on purpose: a soft contact has an answer that is unique, can be differentiated and inverted, and
costs the same in every step. The columns *stiff* have much stiffer settings, of kinds that the documentation describes.

* **frictionbench** is no engine: its contacts are rigid, their friction problems are solved by `interior_point` to 1e-8, and
  time is stepped by Anitescu and Potra's scheme. What remains is the error of this scheme, of first order, and nothing where a
  body rests. A body may overlap by a step's motion when it lands, and restitution acts at the end of the step.
* **MuJoCo** is as it is by default: pyramidal cones, `impratio` 1, `solref` of 20 ms. A pyramid slows a box that is thrown
  askew along one of its axes first, so that its path bends; a soft contact creeps under a steady load in proportion to the
  load. *Stiff*: elliptic cones, `impratio` 100, `noslip_iterations`, `solref` of two steps, `solimp` .99. It has no
  coefficient of restitution. In the rows with e > 0 both columns have a `solref` of the default time constant, 20 ms, and the
  damping ratio with which a spring that does not pull lets go at e times the speed, .255 for e = .5, or `-5000 0` for e = 1;
  such contacts last some steps, so that they need small ones. For e = 0 a critically damped one lets go at e^-2 times the
  speed, .27 m/s, which is that row.
* **Drake** has contacts by surfaces (hydroelastic), which have to be switched on, with the default modulus of 1e7 Pa and the
  default approximation, kLagged. Its creep is the stiction tolerance, by default 1e-4 m/s.
  A surface with dissipation resists rolling, which a point does not: the ball's row contains that. An elastic foundation of
  these moduli and Drake's default dissipation of 50 s/m, integrated by hand, loses 0.10 m/s, and 0.18 m/s with 1e6 Pa; the
  rest is that a sphere is a polyhedron there (`resolution_hint`, 2 cm), and the implicit step.
  *Margin*: `margin` of 1e-4 m, which the documentation names. *Softer*: 1e6 Pa. *Stiff*: 1e9 Pa, where the documentation calls
  1e5 to 1e7 good approximations of rigid contact, the approximation kSimilar, of which it says that bodies glide, and a
  stiction tolerance of 1e-6 m/s. Where a body is nearly rigid, its period of oscillation
  short against a step, flat
  faces on each other lose and gain contact from step to step (RobotLocomotion/drake, issues 21510 and 21514): the default
  modulus does this to the sliding box of 1 kg. The margin was made against it, *softer* has the same box without it. An
  elastic foundation also tips over early: with the stiffness K per area the strip it stands on at last shrinks like K^(-1/3),
  and with it the distance from width/height, for every step alike. It has no coefficient of restitution: its dissipation acts
  in proportion to the speed, and implicit steps damp besides, so that these rows are left out.
* **PyBullet** is as it is by default, 50 sequential impulses a step, but without the damping of every motion, 0.04 (1 + |v|) a
  second, which would be no error of a contact, and with `restitutionVelocityThreshold` 0. *Stiff*: 1000 of them, none left out.
  A contact is made before bodies touch: the speed after the impact is the rebound's less gap over step, so that by default a
  rebound depends on where a step meets the ground, and is nearly lost at 1 ms. *Stiff* has `contactProcessingThreshold` 0 in
  the rows with e > 0, which restores it.
* **Rapier** is as it is by default, but that bodies do not sleep; its package for Python is in single precision. It
  takes 4 substeps, has soft contacts of 30 Hz (60 Hz on fixed bodies), and one friction for a group of contacts. *Stiff*: 20
  substeps and 300 Hz. Its other model of friction, `COULOMB`, gave stopping distances 27 mm longer at each of these
  settings and is not used. A soft contact that carries a thousand times the weight of the lighter body gives way: by
  default the heavy box sinks through the light one.
* **Not measured**: Newton 1.8 with Kamino, a beta by its authors' word. It runs on a processor, after a minute of compilation,
  and its sliding box stopped 5.0 mm early at a step of 5 ms, as a first-order scheme does; at some tenths of a second a step
  the whole column would take hours. Genesis, which needs PyTorch, was not installed.

Bodies are put down at rest or with their speed, touching what they stand on: a compliant contact begins with an oscillation
that the closed forms do not have, and that the box on the slope can feel. The box that tips has settled on level ground before.

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
    return "\n".join(f"* **{one.name}**: {_text(one)}" for one in PHENOMENA)


def _text(one: Phenomenon) -> str:
    """The docstring of the measure, in a line."""
    return " ".join(str(getattr(one.measure, "func", one.measure).__doc__).split())


def _errors(one: Phenomenon, make: Make) -> str:
    errors = [_error(one, make, step) for step in STEPS]
    return "–" if set(errors) == {"–"} else " / ".join(errors)


def _error(one: Phenomenon, make: Make, step: float) -> str:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return f"{one.measure(make, step) - one.exact:.1e}"
        except Unsupported:
            return "–"
        except (Exception, SystemExit) as error:  # whatever an engine raises is its cell
            return f"failed: {type(error).__name__}"


if __name__ == "__main__":
    print(page(), end="")
