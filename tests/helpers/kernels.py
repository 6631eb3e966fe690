"""Compiled wrappers of functions that the solvers' kernels call, so that tests can call them."""

from frictionbench.problems.compiled import kernel
from frictionbench.solvers.interior import alart_curnier, newton, planar_newton, point, spatial_newton


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


@kernel
def assemble(system, space, point, work):
    """Newton's matrix added up in the fronts, as linearise does before it factorises it."""
    work.storage[:] = 0.0
    for k in range(len(system.slot)):
        work.storage[system.slot[k]] += system.constant[k]
    if space is None:
        planar_newton.add_planar_stiffness(system, point, work)
    else:
        spatial_newton.add_spatial_stiffness(system, point, work)
