"""Compiled wrappers of functions that the solvers' kernels call, so that tests can call them."""

from frictionbench.problems.compiled import kernel
from frictionbench.solvers import proximal_newton
from frictionbench.solvers.interior import newton, point
from frictionbench.solvers.pivots import lu_basis
from frictionbench.solvers.sparse_lu import multifrontal
from frictionbench.solvers.sweeps import laws


@kernel
def evaluate_point(*arguments):
    return newton.evaluate_point(*arguments)


@kernel
def linearise(*arguments):
    return newton.linearise(*arguments)


@kernel
def assemble(*arguments):
    return newton.assemble(*arguments)


@kernel
def direction(*arguments):
    return newton.direction(*arguments)


@kernel
def new_point(*arguments):
    return point.new_point(*arguments)


@kernel
def longest(*arguments):
    return point.longest(*arguments)


@kernel
def add_products(*arguments):
    return point.add_products(*arguments)


@kernel
def equations(*arguments):
    return proximal_newton.equations(*arguments)


@kernel
def newton_step(*arguments):
    return proximal_newton.newton_step(*arguments)


@kernel
def factorise_basis(*arguments):
    return lu_basis.factorise_basis(*arguments)


@kernel
def set_complementary_basis(*arguments):
    return lu_basis.set_complementary_basis(*arguments)


@kernel
def basic_z(*arguments):
    return lu_basis.basic_z(*arguments)


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
