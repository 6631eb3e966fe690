"""Accelerated projected gradient descent on the relaxation's dual, and on Coulomb's law itself.

The convex relaxation's impulses minimise  ½ r'W r + q'r  over the product K of the contacts' cones. The gradient is the contact
velocity u, and the projection onto K is made contact by contact. A step along the negative gradient, projected onto the cones,

    r+ = P_K(y - u(y)/(L s)),    y+ = r+ + beta (r+ - r),

where s are the contacts' scales, is followed by Nesterov's momentum, which restarts whenever a step goes uphill
(solvers.sweeps.projected_gradient).

`apgd_coulomb` takes the same steps along de Saxcé's shifted velocity u + mu |u_t| e_n. Its fixed points are Coulomb solutions.
The shifted velocity is not a gradient, and no convergence theorem is known.

References: Nesterov 1983; O'Donoghue and Candès 2015 for the restart; Mazhar, Heyn, Negrut and Tasora 2015.
"""

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, solver
from frictionbench.solvers.sweeps.form import ContactForm, asked, begin, contact_form
from frictionbench.solvers.sweeps.projected_gradient import PATIENCE, descend
from frictionbench.solvers.sweeps.stopping import monitor

LIMIT = 20_000  # iterations by default, mostly with one product with W each: twice the sweeps of nsgs


@solver("apgd", family="splitting", model="relaxation", dimension=(2, 3), warm_start=True)
class APGD:
    """Accelerated projected gradient descent on the convex relaxation's dual.

    precision: double or single.
    Work: iterations, and products with W. History: the relaxation's residual at every iteration.
    """

    precision: str = "double"

    shift = 0.0

    def form(self, problem: FrictionProblem) -> ContactForm:
        return contact_form(problem, relaxed=not self.shift, precision=self.precision)

    def solve(self, form: ContactForm, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        r, limit = begin(form, start), LIMIT if limit is None else limit
        monitored = monitor(asked(form, tol), limit, PATIENCE)
        iterations, products = descend(form, r, self.shift, monitored)
        return monitored.answer(r, iterations=iterations, products=products)


@solver("apgd_coulomb", family="splitting", model="coulomb", dimension=(2, 3), warm_start=True)
class APGDCoulomb(APGD):
    """Accelerated projected gradient steps along de Saxcé's shifted velocity.

    precision: double or single.
    Work: iterations, and products with W. History: the residual at every iteration.
    """

    shift = 1.0
