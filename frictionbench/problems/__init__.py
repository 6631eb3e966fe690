"""Scenes, the friction problem of one time step and its forms, the schemes that step a scene, the residual and the verifier.

Each name is imported when it is first used, so that the verdicts alone (problems.verdicts) load no kernels.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from frictionbench.problems.answer import Answer, Status
    from frictionbench.problems.check import InputError
    from frictionbench.problems.forms.lcp import LCP
    from frictionbench.problems.friction import FrictionProblem
    from frictionbench.problems.scene import Scene
    from frictionbench.problems.schemes import SCHEMES, start
    from frictionbench.problems.spatial.bodies import HalfSpace, solid_box, solid_sphere
    from frictionbench.problems.verdicts import Verdict

__all__ = [
    "LCP",
    "SCHEMES",
    "Answer",
    "FrictionProblem",
    "HalfSpace",
    "InputError",
    "Scene",
    "Status",
    "Verdict",
    "solid_box",
    "solid_sphere",
    "start",
]

_DEFINED_IN = {
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
    globals()[name] = value = getattr(import_module(f"{__name__}.{_DEFINED_IN[name]}"), name)
    return value
