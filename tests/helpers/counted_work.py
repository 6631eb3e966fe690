"""Script that solves problems with every solver, uncompiled, and counts the calls of the kernels independently of the solvers.

Prints JSON: [solver, its work counters, {kernel: calls}] for each case.
"""

import json
import sys
import warnings
from collections import Counter

from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.solvers import available, solve
from tests.helpers.friction_problems import spatial

KERNELS = (
    ("frictionbench.solvers.sparse_lu.multifrontal", "factorise", "sparse factorisations", lambda arguments: 1),
    ("frictionbench.solvers.pivots.lu_basis", "factorise_basis", "basis factorisations", lambda arguments: 1),
    ("frictionbench.solvers.pivots.lu_basis", "replace_column", "basis exchanges", lambda arguments: 1),
    ("frictionbench.solvers.pivots.inverse_basis", "exchange_pair", "exchanges", lambda arguments: 1),
    ("frictionbench.solvers.pivots.tableau", "exchange", "exchanges", lambda arguments: 1),
    ("frictionbench.solvers.pivots.inverse_basis", "refactor", "inversions", lambda arguments: 1),
    ("frictionbench.solvers.merit_newton", "solve_dense", "dense factorisations", lambda arguments: 1),
    ("frictionbench.solvers.sweeps.form", "state", "products", lambda arguments: 1),
    ("frictionbench.solvers.sweeps.gauss_seidel", "planar_sweeps", "sweeps", lambda arguments: arguments[-1]),
    ("frictionbench.solvers.sweeps.gauss_seidel", "spatial_sweeps", "sweeps", lambda arguments: arguments[-1]),
    ("frictionbench.solvers.admm", "_alternate", "alternations", lambda arguments: arguments[-1]),
)
calls: Counter[str] = Counter()


def count(module, name, label, amount):
    """Replace a kernel in all modules that import it by one that counts its calls."""
    original = getattr(sys.modules[module], name)

    def counted(*arguments):
        calls[label] += int(amount(arguments))
        return original(*arguments)

    for known in [known for title, known in sys.modules.items() if title.startswith("frictionbench.solvers")]:
        for key, value in list(vars(known).items()):
            if value is original:
                setattr(known, key, counted)


def cases():
    problems = (random_problem(1, 3, friction=0.3), random_problem(4, 6, friction=2.0), spatial(1, contacts=3))
    for name, info in available().items():
        if info.needs:
            continue
        for problem in problems:
            if not info.refuses(problem):
                yield name, problem, 1e-8, None
                yield name, problem, 1e-15, 7
    for trapped in (random_problem(19, 20), spatial(23, contacts=1, nv=6, friction=0.1)):  # in the first phase
        yield "interior_point", trapped, 1e-8, None


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # integers that wrap around, on purpose
    lemke = sys.modules["frictionbench.solvers.lemke"]
    lemke.draw = lambda seed, drawn, draw=lemke.draw: draw(seed % 2**64, drawn)  # -1 wraps around in compiled code
    for kernel in KERNELS:
        count(*kernel)
    found = []
    for name, problem, tol, limit in cases():
        calls.clear()
        answer = solve(problem, name, tol=tol, limit=limit)
        found.append((name, {unit: int(n) for unit, n in answer.work.items()}, dict(calls)))
    print(json.dumps(found))
