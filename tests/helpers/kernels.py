"""Parts of kernels as tests may call them."""

from frictionbench.problems.compiled import kernel
from frictionbench.solvers.interior import alart_curnier, newton, point


@kernel
def evaluate_point(system, space, point, defect, work):
    return newton.evaluate_point(system, space, point, defect, work)


@kernel
def linearise(system, space, point, work):
    newton.linearise(system, space, point, work)


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
def to_geodesics(system, space, at, step):
    point.to_geodesics(system, space, at, step)


@kernel
def equations(system, state, anchor, rho, work):
    return alart_curnier.equations(system, state, anchor, rho, work)


@kernel
def newton_step(system, state, anchor, rho, step, work):
    alart_curnier.newton_step(system, state, anchor, rho, step, work)
