"""Compiled wrappers of functions that the solvers' kernels call, so that tests can call them."""

from frictionbench.problems.compiled import kernel
from frictionbench.solvers.interior import newton
from frictionbench.solvers.sparse_lu import multifrontal
from frictionbench.solvers.sweeps import laws


@kernel
def assemble(*arguments):
    return newton.assemble(*arguments)


@kernel
def analyse(*arguments):
    return multifrontal.analyse(*arguments)


@kernel
def position_in_front(*arguments):
    return multifrontal.position_in_front(*arguments)


@kernel
def determinant_sign(*arguments):
    return multifrontal.determinant_sign(*arguments)


@kernel
def solve_factorised(*arguments):
    return multifrontal.solve_factorised(*arguments)


@kernel
def spatial_contact(*arguments):
    return laws.spatial_contact(*arguments)
