"""`frictionbench show`: the motion of a scene, simulated in a worker with its limits."""

import re
from dataclasses import replace

import numpy as np

from frictionbench.harness.cells import worker
from frictionbench.harness.plans.plan import owner
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.harness.workers.pool import Task, scratch_pool
from frictionbench.problems.catalogue import find_scene
from frictionbench.problems.check import require
from frictionbench.problems.schemes import require_scheme
from frictionbench.problems.spec import parse
from frictionbench.results.conventions import DEFAULT_SCHEME
from frictionbench.results.motion import Motion, decoded

EXACT_SOLVERS = {2: "lemke", 3: "interior_point"}
MAX_SECONDS = 3600.0  # seconds to simulate a scene: the user can interrupt it earlier


def energy_balance(motion: Motion) -> str:
    """Return the energy balance in one line."""
    energy = motion.energy
    end, rise = energy[-1] - energy[0], np.diff(energy, prepend=energy[0]).max()
    worst = motion.residual.max(initial=0.0, where=np.isfinite(motion.residual))
    most = f"the largest rise in a step is {rise:.2g} J" if rise > 0 else "never rises in a step"
    text = f"energy, kinetic (at most {motion.kinetic.max():.3g} J) and potential"
    return f"{text}: {'rises' if end > 0 else 'falls'} by {abs(end):.2g} J in all, {most}; worst residual {worst:.0g}"


def page_name(scene: str, solver: str | None, scheme: str) -> str:
    """Return the page's file name, from the scene, the solver and scheme if not the default: stack-blocks=5-moreau.html."""
    parts = (scene, solver or "", scheme if scheme != DEFAULT_SCHEME else "")
    return "-".join(re.sub(r"[^\w.=]+", "-", text).strip("-") for text in parts if text) + ".html"


def recorded(scene_spec: str, solver_spec: str | None, scheme: str, steps: int | None) -> Motion:
    """Record the motion of a scene. solver_spec: by default an exact solver for the scene's dimension.

    Errors: InputError naming the field.
    """
    require_scheme(scheme)
    name, settings = parse("scene", scene_spec)
    solver_spec = solver_spec or EXACT_SOLVERS[find_scene(name, settings).dimension]
    variants, plugins = load_plugins([solver_spec])
    require(len(variants) == 1, "solver", f"{solver_spec} defines {len(variants)} solvers; name one of them")
    (variant,) = variants
    with scratch_pool(plugins) as pool:
        call = (name, settings, variant, scheme, steps)
        (outcome,) = pool.run([Task(worker.run_show, call, MAX_SECONDS, owner(variant, plugins))])
    motion = decoded(outcome.result(f"scene: {scene_spec} cannot be shown with {variant}"), f"solver: {variant}")
    return replace(motion, scene=name, solver=variant)
