"""Friction problems of one step, one file per kind, registered by a decorator (problems.instances.catalogue).

make_instance("cubes", boxes=10, friction=0.5)        make_instance("random", seed=3)
"""

from frictionbench.problems.catalogue import import_all
from frictionbench.problems.instances.catalogue import CATALOGUE, instances, make_instance

import_all(__name__, __path__)

__all__ = ["CATALOGUE", "instances", "make_instance"]
