"""Friction problems of one step, one file per kind, registered by a decorator (problems.catalogue).

make_instance("cubes", boxes=10, friction=0.5)        make_instance("random", seed=3)
"""

from frictionbench.problems.catalogue import instances, make_instance

__all__ = ["instances", "make_instance"]
