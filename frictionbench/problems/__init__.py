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

_DEFINED_IN = {
    "Census": "analysis.census",
    "census": "analysis.census",
    "frictionless_answer": "analysis.frictionless",
    "idle": "analysis.frictionless",
    "refined": "analysis.outcomes",
    "velocity_distance": "analysis.outcomes",
    "Shape": "analysis.polyhedra",
    "is_p0": "analysis.thresholds",
    "is_pointed": "analysis.thresholds",
    "comply": "compliant",
    "ReducedScene": "generalised",
    "recorded_steps": "instances.recorded_step",
    "relaxation_residual": "residual",
    "GRAVITY": "scene",
    "NoSolution": "schemes",
    "Step": "schemes",
    "Impact": "schemes.event_driven",
    "follow": "schemes.event_driven",
    "newton": "schemes.event_driven",
    "impact": "schemes.impact",
    "Scheme": "schemes.stepping",
    "Solve": "schemes.stepping",
    "Solved": "schemes.stepping",
    "first_problem": "simulate",
    "simulation": "simulate",
    "ACCEPTED": "verdicts",
    "measured": "verdicts",
    "LCP": "forms.lcp",
    "Answer": "answer",
    "FrictionProblem": "friction",
    "InputError": "check",
    "SCHEMES": "schemes",
    "Scene": "scene",
    "start": "schemes",
    "HalfSpace": "spatial.bodies",
    "solid_box": "spatial.bodies",
    "solid_sphere": "spatial.bodies",
    "Status": "answer",
    "Verdict": "verdicts",
}


def __getattr__(name: str) -> Any:
    if name not in _DEFINED_IN:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value = getattr(
        import_module(f"{__name__}.{_DEFINED_IN[name]}"), {"simulation": "simulate"}.get(name, name)
    )
    return value
