"""Compiled wrappers of functions that the solvers' kernels call, so that tests can call them."""

from frictionbench.problems.compiled import kernel
from frictionbench.solvers import proximal_newton
from frictionbench.solvers.interior import newton, point
from frictionbench.solvers.pivots import lemke_path


@kernel
def evaluate_point(system, space, point, defect, work):
    return newton.evaluate_point(system, space, point, defect, work)


@kernel
def linearise(system, space, point, work):
    newton.linearise(system, space, point, work)


@kernel
def assemble(system, space, point, work):
    newton.assemble(system, space, point, work)


@kernel
def direction(system, space, point, target, defect, step, work):
    newton.direction(system, space, point, target, defect, step, work)


@kernel
def new_point(system):
    return point.new_point(system)


@kernel
def longest(system, space, at, step, limit):
    return point.longest(system, space, at, step, limit)


@kernel
def longest_in_cone(a, step, limit):
    return point.longest_in_cone(a, step, limit)


@kernel
def to_geodesics(system, space, at, step):
    point.to_geodesics(system, space, at, step)


@kernel
def add_products(space, factor, x, s, total):
    point.add_products(space, factor, x, s, total)


@kernel
def equations(system, state, anchor, rho, work):
    return proximal_newton.equations(system, state, anchor, rho, work)


@kernel
def newton_step(system, state, anchor, rho, step, work):
    proximal_newton.newton_step(system, state, anchor, rho, step, work)


@kernel
def entering_column(state, p, z_enters, accuracy):
    return lemke_path.entering_column(state, p, z_enters, accuracy)


@kernel
def exchange(state, p, z_enters, s, t):
    lemke_path.exchange(state, p, z_enters, s, t)
