"""Kamino's proximal ADMM and accelerated projected gradients: Newton's solvers of articulated bodies, on the processor.

They solve Coulomb's law by de Saxcé's shift of the velocity, in single precision. Their public functions take models. Here a
template with one body and nc contacts is used: the Delassus matrix, free velocities and friction of its dense dual problem are
overwritten, and the problem is preconditioned as Kamino does.

Licence: Apache-2.0 (Newton and Warp).
Form: the dimensionless Delassus matrix, dense, with three rows a contact, (t1, t2, n); the second tangent of a planar one is
    decoupled. Setup: the template, once per size; up to 80 contacts it is factorised without blocks (LLTSequentialSolver),
    above in blocks, as by default (LLTBlockedSolver). Solve: the transfer into it, the solver's solve, and reading the
    impulses. What Warp compiles and records for a size, some ten seconds, is not timed.
Clock: none.
Charged: both are made for many worlds at once on a graphics card. Their kernels are recorded once per size as a graph
    (warp.ScopedCapture), which Warp replays on one processor without Python; some 20 µs of form and transfer at 2 contacts
    are added.
Settings: PADMM's initial penalty rho_0 is 1; tuned is 0.1, with fewer iterations on stacks and more on random bodies,
    `frictionbench solve 'stack[blocks=5,push=1]' --tol 1e-4 --solver 'kamino[method=padmm]' --solver
    'kamino[method=padmm,settings=tuned]'`. APGD corrects the shift once by default, which solves a relaxation; here it may 200
    times. PADMM's limit of 200 iterations is raised to 2000.
Tolerance: of PADMM's three residuals and of APGD's natural map eps/3, eps as in solvers.outside.scaled_delassus, but at least
    1e-7, about a unit of rounding; where eps is less than that, it does not claim more than rounding allows.
Flaws: at 1e-6 its residuals, in single precision, are met where the verified one is up to five times the tolerance, or never,
    `frictionbench solve 'house_of_cards[storeys=4]' --tol 1e-6 --solver 'kamino[method=padmm]'`. APGD may correct the shift
    200 times, with 80 contacts for seconds, and end above the tolerance, `frictionbench solve 'stack[blocks=5,push=1]' --tol
    1e-6 --solver 'kamino[method=apgd]'`.
Reference: Tsounis, Grandia and Bächer 2025, arXiv:2504.19771; the Newton developers, Newton.
"""

from functools import cache
from importlib import import_module
from typing import Any

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.outside import untimed
from frictionbench.solvers.outside.scaled_delassus import TANGENTS_FIRST, ScaledDelassus, scaled_delassus

_KAMINO = "newton._src.solvers.kamino._src."
_MARGIN = 3  # with 10 it claims fewer of its accurate answers, with 2 and less more are near misses: docs/fairness.md
_LEAST = 1e-7  # of residuals: a unit of rounding of impulses and velocities of size 1
_SEQUENTIAL = 80  # contacts up to which the factorisation without blocks is the faster one on a processor
_LIMITS = {"padmm": 2000, "apgd": 200}  # PADMM's iterations, and APGD's corrections of the shift, of 64 iterations each
Prepared = tuple[ScaledDelassus, tuple[Any, ...]]  # and Kamino's template


@solver(
    "kamino",
    family="splitting",
    model="coulomb",
    dimension=(2, 3),
    needs=("newton", "warp-lang"),
    lacks=("friction_bias", "asymmetry"),
    precision="single",
    variants=("method=padmm", "method=padmm,settings=tuned", "method=apgd"),
)
class Kamino:
    """Kamino's proximal ADMM or accelerated projected gradients, in single precision. (outside)

    method: padmm or apgd. settings: default or tuned. Work: iterations.
    """

    method: str = "padmm"
    settings: str = "default"

    def form(self, problem: FrictionProblem) -> ScaledDelassus:
        return scaled_delassus(problem, TANGENTS_FIRST)

    def setup(self, scaled: ScaledDelassus) -> Prepared:
        return scaled, _template(len(scaled.friction), self.method)

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        scaled, (graph, (*problem, config, corrections, found, impulses), _) = prepared
        eps, most = max(scaled.share * tol / _MARGIN, _LEAST), limit or _LIMITS[self.method]
        # A solve changes them.
        for array, values in zip(problem, (scaled.W, scaled.q, scaled.friction), strict=True):
            array[: values.size] = values.ravel()
        if self.method == "padmm":
            config[["primal_tolerance", "dual_tolerance", "compl_tolerance"]] = eps
            config["max_iterations"], config["rho_0"] = most, 0.1 if self.settings == "tuned" else 1.0
        else:
            config["tolerance"] = corrections["tolerance"] = eps
            corrections["max_nonlinear_corrections"] = most
        import_module("warp").capture_launch(graph)
        status = found[0]
        ended = status["converged"] if self.method == "padmm" else status["apgd_residual"] <= eps
        reached = Status.SOLVED if eps <= scaled.share * tol else Status.ROUNDING
        r = impulses[: len(scaled.q)].astype(float)
        return scaled.answer(r, reached if ended else Status.WORK_LIMIT, iterations=int(status["iterations"]))


@cache
@untimed()
def _template(nc: int, method: str) -> tuple[Any, ...]:
    """Of nc contacts: the graph of preconditioning, cold start and solve, with all kernels compiled; views of D, v_f and mu of
    the dual problem, of the solver's options, of those of APGD's corrections, of its status and its impulses; and what owns
    their memory."""
    warp: Any = import_module("warp")
    warp.config.log_level = 40  # errors only
    newton = import_module("newton")
    kinematics, solvers = _KAMINO + "kinematics.", _KAMINO + "solvers."
    constraints = import_module(kinematics + "constraints")
    builder = newton.ModelBuilder()
    builder.add_shape_box(builder.add_body(mass=1.0), hx=0.1, hy=0.1, hz=0.1)
    model = import_module(_KAMINO + "core.model").ModelKamino.from_newton(builder.finalize(device="cpu"))
    model.time.dt.fill_(1e-3)
    model.time.inv_dt.fill_(1e3)
    data, limits = model.data(), import_module(kinematics + "limits").LimitsKamino(model=model)
    contacts = import_module(_KAMINO + "geometry.contacts").ContactsKamino(capacity=[nc], device="cpu")
    constraints.make_unilateral_constraints_info(model, data, limits, contacts)
    contacts.world_active_contacts.fill_(nc)
    contacts.model_active_contacts.fill_(nc)
    constraints.update_constraints_info(model=model, data=data)
    jacobians = import_module(kinematics + "jacobians").DenseSystemJacobians(model=model, limits=limits, contacts=contacts)
    parts = {"model": model, "data": data, "limits": limits, "contacts": contacts, "jacobians": jacobians}
    factor = getattr(import_module(_KAMINO + "linalg"), "LLTSequentialSolver" if nc <= _SEQUENTIAL else "LLTBlockedSolver")
    dual = import_module(_KAMINO + "dynamics.dual").DualProblem(**parts, solver=factor, sparse=False)
    if method == "padmm":
        padmm = import_module(solvers + "padmm")
        library_solver = padmm.PADMMSolver(model=model, warmstart=padmm.PADMMWarmStartMode.NONE)
    else:
        dvi = import_module(solvers + "dvi").DVISolver
        library_solver = dvi(**parts, problem=dual, config=dvi.Config(unilateral_solver="apgd"))
    dual.zero()
    with warp.ScopedCapture(device="cpu") as capture:
        dual._build_dual_preconditioner()
        dual._apply_dual_preconditioner_to_dual()
        library_solver.coldstart()
        library_solver.solve(dual)
    found = library_solver.data
    corrections = found.config if method == "padmm" else library_solver._apgd.config
    arrays = dual.data.D, dual.data.v_f, dual.data.mu, found.config, corrections, found.status, found.solution.lambdas
    return capture.graph, tuple(array.numpy() for array in arrays), (dual, library_solver)
