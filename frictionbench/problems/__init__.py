"""Scenes, the friction problem of one time step and its forms, the schemes that step a scene, the residual and the verifier.

Each name is imported when it is first used, so that the verdicts alone (problems.verdicts) load no kernels.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from frictionbench.problems.analysis.census import Census, census
    from frictionbench.problems.analysis.frictionless import frictionless_answer, idle
    from frictionbench.problems.analysis.outcomes import refined, velocity_distance
    from frictionbench.problems.analysis.polyhedra import Shape
    from frictionbench.problems.analysis.thresholds import is_p0, is_pointed
    from frictionbench.problems.answer import Answer, Status
    from frictionbench.problems.check import InputError
    from frictionbench.problems.compliant import comply
    from frictionbench.problems.forms.lcp import LCP
    from frictionbench.problems.friction import FrictionProblem
    from frictionbench.problems.generalised import ReducedScene
    from frictionbench.problems.instances.recorded_step import recorded_steps
    from frictionbench.problems.residual import relaxation_residual
    from frictionbench.problems.scene import GRAVITY, Scene
    from frictionbench.problems.schemes import SCHEMES, NoSolution, Step, start
    from frictionbench.problems.schemes.event_driven import Impact, follow, newton
    from frictionbench.problems.schemes.impact import impact
    from frictionbench.problems.schemes.stepping import Scheme, Solve, Solved
    from frictionbench.problems.simulate import first_problem
    from frictionbench.problems.simulate import simulate as simulation
    from frictionbench.problems.spatial.bodies import HalfSpace, solid_box, solid_sphere
    from frictionbench.problems.verdicts import ACCEPTED, Verdict, measured

__all__ = [
    "ACCEPTED",
    "GRAVITY",
    "LCP",
    "SCHEMES",
    "Answer",
    "Census",
    "FrictionProblem",
    "HalfSpace",
    "Impact",
    "InputError",
    "NoSolution",
    "ReducedScene",
    "Scene",
    "Scheme",
    "Shape",
    "Solve",
    "Solved",
    "Status",
    "Step",
    "Verdict",
    "census",
    "comply",
    "first_problem",
    "follow",
    "frictionless_answer",
    "idle",
    "impact",
    "is_p0",
    "is_pointed",
    "measured",
    "newton",
    "recorded_steps",
    "refined",
    "relaxation_residual",
    "simulation",
    "solid_box",
    "solid_sphere",
    "start",
    "velocity_distance",
]

_DEFINED_IN = {  # by module
    "analysis.census": ("Census", "census"),
    "analysis.frictionless": ("frictionless_answer", "idle"),
    "analysis.outcomes": ("refined", "velocity_distance"),
    "analysis.polyhedra": ("Shape",),
    "analysis.thresholds": ("is_p0", "is_pointed"),
    "answer": ("Answer", "Status"),
    "check": ("InputError",),
    "compliant": ("comply",),
    "forms.lcp": ("LCP",),
    "friction": ("FrictionProblem",),
    "generalised": ("ReducedScene",),
    "instances.recorded_step": ("recorded_steps",),
    "residual": ("relaxation_residual",),
    "scene": ("GRAVITY", "Scene"),
    "schemes": ("SCHEMES", "NoSolution", "Step", "start"),
    "schemes.event_driven": ("Impact", "follow", "newton"),
    "schemes.impact": ("impact",),
    "schemes.stepping": ("Scheme", "Solve", "Solved"),
    "simulate": ("first_problem", "simulation"),
    "spatial.bodies": ("HalfSpace", "solid_box", "solid_sphere"),
    "verdicts": ("ACCEPTED", "Verdict", "measured"),
}


def __getattr__(name: str) -> Any:
    module = next((module for module, names in _DEFINED_IN.items() if name in names), None)
    if module is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    own = {"simulation": "simulate"}.get(name, name)
    globals()[name] = value = getattr(import_module(f"{__name__}.{module}"), own)
    return value
