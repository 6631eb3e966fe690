"""Calls by hand of libraries of linear complementarity problems, on the friction LCP."""

import io
import re
from functools import cache
from importlib import import_module
from time import perf_counter
from typing import Any

import numpy as np

from frictionbench.harness.direct.given import Arrays, Called, lcp, of_lcp


def quantecon(given: Arrays, tol: float) -> Called:
    lemke: Any = import_module("quantecon.optimize.lcp_lemke").lcp_lemke
    M, q = lcp(given)
    found = lemke(M, q)
    return Called(of_lcp(found.z), found.success)


def drake(given: Arrays, tol: float) -> Called:
    library: Any = import_module("pydrake.solvers")
    M, q = lcp(given)
    program = library.MathematicalProgram()
    z = program.NewContinuousVariables(len(q))
    program.AddLinearComplementarityConstraint(M, q, z)
    found = library.UnrevisedLemkeSolver().Solve(program, None, None)
    return Called(of_lcp(found.GetSolution(z)), found.is_success())


def path(given: Arrays, tol: float) -> Called:
    gp: Any = import_module("gamspy")
    begun = perf_counter()
    M, q = lcp(given)
    forming = perf_counter() - begun
    model, parameters, z = _gams_model(len(q))
    for symbol, values in zip(parameters, (M, q), strict=True):
        symbol.setRecords(values)
    z.setRecords(np.zeros(len(q)))
    log = io.StringIO()
    options = {"convergence_tolerance": tol / 10}
    model.solve(solver="path", solver_options=options, output=log, options=gp.Options(solve_link_type="memory"))
    clock = re.search(r"Total Time[. ]*([\d.]+)", log.getvalue())
    claimed = model.status.name in ("OptimalGlobal", "OptimalLocal")
    return Called(of_lcp(z.records["level"].to_numpy()), claimed, forming + float(clock[1]) if clock else None)


@cache
def _gams_model(n: int) -> tuple[Any, tuple[Any, Any], Any]:
    """GAMSPy's model of an LCP of n unknowns, the parameters M and q, and z."""
    gp: Any = import_module("gamspy")
    gp.set_options({"ALLOW_AMBIGUOUS_EQUATIONS": "yes"})
    made = gp.Container()
    i = gp.Set(made, "i", records=[str(k) for k in range(n)])
    j = gp.Alias(made, "j", alias_with=i)
    M, q = gp.Parameter(made, "M", domain=[i, j]), gp.Parameter(made, "q", domain=[i])
    z, w = gp.Variable(made, "z", type="positive", domain=[i]), gp.Equation(made, "w", domain=[i])
    w[i] = gp.Sum(j, M[i, j] * z[j]) + q[i] >= 0
    return gp.Model(made, "lcp", problem="MCP", matches={w: z}), (M, q), z
