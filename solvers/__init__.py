"""One file a method or outside library, one signature for all: see solvers.interface."""

from solvers import (
    admm,
    anitescu_hart,
    apgd,
    ccp,
    ccp_cone,
    dantzig,
    fischer_newton,
    hybrid,
    interior_point,
    lemke,
    minmap_newton,
    murty,
    nncg,
    nsgs,
    path_search,
    relaxation_ip,
    staggered,
)
from solvers.interface import Answer, Solver, SolverInfo, Status, available, find, solve, solver

METHODS = (
    *(admm, anitescu_hart, apgd, ccp, ccp_cone, dantzig, fischer_newton, hybrid),
    *(interior_point, lemke, minmap_newton, murty, nncg, nsgs, path_search, relaxation_ip, staggered),
)

__all__ = ["METHODS", "Answer", "Solver", "SolverInfo", "Status", "available", "find", "solve", "solver"]
