"""Calls of outside libraries as a user would write them by hand, with which the adapters of solvers.outside are compared.

They know nothing of the adapters: each forms what its library takes with numpy from the dense arrays of a problem, unscaled,
and returns the contact impulses and whether the library reports success (harness.direct.given).
"""

from collections.abc import Callable
from functools import partial

from frictionbench.harness.direct import complementarity, contact, relaxation
from frictionbench.harness.direct.given import Arrays, Called

# The variant of an adapter, and the call by hand that makes the same choices.
CALLS: dict[str, Callable[[Arrays, float], Called]] = {
    "clarabel[keep=false]": relaxation.clarabel,
    "osqp[keep=false]": relaxation.osqp,
    "proxsuite[matrices=sparse]": relaxation.proxsuite,
    "piqp": relaxation.piqp,
    "daqp": relaxation.daqp,
    "quadprog": relaxation.quadprog,
    "qpmad": relaxation.qpmad,
    "ccp[backend=clarabel]": relaxation.qpsolvers,
    "ccp[backend=highs]": partial(relaxation.qpsolvers, backend="highs"),
    "ccp[backend=highs,settings=tuned]": partial(relaxation.qpsolvers, backend="highs", qp_regularization_value=0.0),
    "ccp_cone[backend=clarabel]": relaxation.cvxpy,
    "casadi[method=qrqp]": relaxation.casadi_qrqp,
    "mujoco_boxqp[settings=default]": relaxation.mujoco_boxqp,
    "quantecon[settings=default]": complementarity.quantecon,
    "drake[method=unrevised]": complementarity.drake,
    "path": complementarity.path,
    "pinocchio[method=admm]": contact.pinocchio,
    "mujoco[method=newton]": contact.mujoco,
    "siconos[method=friction_2d_nsgs]": contact.siconos,
}
