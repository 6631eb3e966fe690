"""Scenes, the friction problem of one time step and its forms, the schemes that step a scene, the residual and the verifier.

Each name is imported when it is first used, so that the verdicts alone (problems.verdicts) load no kernels.
"""

from typing import TYPE_CHECKING

from frictionbench.lazy import importer

if TYPE_CHECKING:
    from frictionbench.problems.analysis.census import Census as Census, census as census
    from frictionbench.problems.analysis.frictionless import idle as idle
    from frictionbench.problems.analysis.outcomes import refined as refined, velocity_distance as velocity_distance
    from frictionbench.problems.analysis.polyhedra import Shape as Shape
    from frictionbench.problems.analysis.thresholds import is_p0 as is_p0
    from frictionbench.problems.answer import Answer as Answer, Status as Status
    from frictionbench.problems.catalogue import generator as generator
    from frictionbench.problems.check import InputError as InputError
    from frictionbench.problems.forms.lcp import LCP as LCP
    from frictionbench.problems.friction import FrictionProblem as FrictionProblem
    from frictionbench.problems.generalised import GeneralisedScene as GeneralisedScene, GivenContacts as GivenContacts
    from frictionbench.problems.instances.recorded_step import recorded_steps as recorded_steps
    from frictionbench.problems.measures import judged as judged, violations as violations
    from frictionbench.problems.residual import relaxation_residual as relaxation_residual
    from frictionbench.problems.scene import GRAVITY as GRAVITY, Scene as Scene
    from frictionbench.problems.schemes import SCHEMES as SCHEMES, NoSolution as NoSolution, Step as Step, start as start
    from frictionbench.problems.schemes.event_driven import Impact as Impact, follow as follow, newton as newton
    from frictionbench.problems.schemes.impact import impact as impact
    from frictionbench.problems.schemes.stepping import Scheme as Scheme, Solve as Solve, Solved as Solved
    from frictionbench.problems.simulate import first_problem as first_problem, simulate as simulation
    from frictionbench.problems.spatial.bodies import (
        HalfSpace as HalfSpace,
        solid_box as solid_box,
        solid_sphere as solid_sphere,
    )
    from frictionbench.problems.subproblems import keep_contacts as keep_contacts
    from frictionbench.problems.verdicts import ACCEPTED as ACCEPTED, Verdict as Verdict, measured as measured

__all__ = ["simulation"]  # the name that is another there
__getattr__ = importer(__name__, __file__)
