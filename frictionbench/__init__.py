"""Compare solvers for the friction LCPs of rigid-body dynamics.

    problems   problem, scene, scenes, instance, instances, FrictionProblem, LCP, load, save, InputError
    engines    capture, mujoco, EngineStep, load_step
    solvers    solve, available, solver, Answer, Status, solve_many, Batch, Answers
    checks     residual, residual_floor, verify, Verdict, contradiction
    results    read_results, plot

Units are SI: velocities in m/s, impulses in N s, masses in kg. Impulses have shape (nc, d) for nc contacts of dimension d (2
planar, 3 spatial), the normal component first.

>>> import frictionbench as fb
>>> problem = fb.scene("stack", blocks=3, push=1.0).problem()
>>> answer = fb.solve(problem, "lemke", tol=1e-8)
>>> fb.verify(problem, answer, tol=1e-8).verdict.value
'solved'

Each name is imported when it is first used, so that `import frictionbench` alone loads neither numpy nor numba.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from frictionbench.lazy import importer

if TYPE_CHECKING:
    from frictionbench import capture, mujoco, plot
    from frictionbench.files import load, load_step, save
    from frictionbench.problems import LCP, Answer, FrictionProblem, InputError, Status, Verdict
    from frictionbench.problems.analysis.contradiction import contradiction
    from frictionbench.problems.catalogue import instances, make_instance as instance, problem_of as problem, scene, scenes
    from frictionbench.problems.packed import Batch
    from frictionbench.problems.recorded.native import EngineStep
    from frictionbench.problems.residual import residual, residual_floor
    from frictionbench.solvers import Answers, available, solve, solve_many, solver
    from frictionbench.tables import read_results
    from frictionbench.verification import verify

    __version__: str

__all__ = [
    "LCP",
    "Answer",
    "Answers",
    "Batch",
    "EngineStep",
    "FrictionProblem",
    "InputError",
    "Status",
    "Verdict",
    "__version__",
    "available",
    "capture",
    "contradiction",
    "instance",
    "instances",
    "load",
    "load_step",
    "mujoco",
    "plot",
    "problem",
    "read_results",
    "residual",
    "residual_floor",
    "save",
    "scene",
    "scenes",
    "solve",
    "solve_many",
    "solver",
    "verify",
]

_imported = importer(__name__, __file__)


def __getattr__(name: str) -> Any:
    return import_module("importlib.metadata").version("frictionbench") if name == "__version__" else _imported(name)


def __dir__() -> list[str]:
    return __all__
