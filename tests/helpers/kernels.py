"""Compiled wrappers of functions that the solvers' kernels call, so that tests can call them."""
# ruff: noqa: PLW0108 - these functions can be called from compiled code only

from frictionbench.problems.compiled import kernel
from frictionbench.solvers.interior import newton
from frictionbench.solvers.sparse_lu import multifrontal
from frictionbench.solvers.sweeps import laws

assemble = kernel(lambda *arguments: newton.assemble(*arguments))
analyse = kernel(lambda *arguments: multifrontal.analyse(*arguments))
position_in_front = kernel(lambda *arguments: multifrontal.position_in_front(*arguments))
determinant_sign = kernel(lambda *arguments: multifrontal.determinant_sign(*arguments))
solve_factorised = kernel(lambda *arguments: multifrontal.solve_factorised(*arguments))
spatial_contact = kernel(lambda *arguments: laws.spatial_contact(*arguments))
