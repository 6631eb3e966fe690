"""The theta scheme of Moreau (1988) and Jean (1999), with Newton restitution.

    M (v+ - v) = h [(1 - theta) k(q, v, t) + theta k(q + h v, v, t + h)] + J' r + F' lam,      F v+ = 0,
    q+ = q + h [(1 - theta) v + theta v+],

with Coulomb's law between r and u = J v+ + e (n'v) e_n at the contacts that touch at the midpoint q + (h/2) v: to first order,
those with phi + (h/2) n'v <= 0. J is also evaluated there. At a closing contact the law is 0 <= n'v+ + e n'v ⟂ r_n >= 0.
Newton's restitution with friction can add energy. theta = 1/2 is Moreau's midpoint rule, theta = 1 is like Euler's implicit
rule. For a given stiffness K, -K q is evaluated at (1 - theta) q + theta q+, and M + (theta h)^2 K replaces M.

Reference: Acary and Brogliato 2008, chapter 10.
"""

from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.stepping import Scheme, Solve, Step, respond, scheme


def theta_scheme(name: str, theta: float) -> Scheme:
    """The scheme with this theta in [0, 1]."""

    @scheme(name)
    def advance(scene: Scene, now: Step, solve: Solve) -> Step:
        h, q, v, t = scene.step, now.q, now.v, now.time
        middle = scene.moved(q, h / 2 * v)
        contacts = scene.contacts(middle)
        force = (1 - theta) * scene.force(q, v, t) + theta * scene.force(scene.moved(q, h * v), v, t + h)
        restitution = scene.restitutions(contacts) * (contacts.normal @ v)
        problem = scene.friction_problem(
            middle, v + h * scene.accelerate(middle, force, theta * h), contacts, bias=restitution, ahead=theta * h
        )
        step, after = respond("step", problem, contacts, solve)
        return Step(t + h, scene.moved(q, h * ((1 - theta) * v + theta * after)), after, contacts, (step,))

    return advance


moreau = theta_scheme("moreau", 0.5)
moreau_euler = theta_scheme("moreau_euler", 1.0)
