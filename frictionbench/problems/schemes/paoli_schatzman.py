"""The scheme of Paoli and Schatzman (2002) in positions, with restitution but without friction; for reference.

    M (q+ - 2 q + q-) = h^2 k + h (N' c + F' lam),      Theta(q+) = 0,
    0 <= phi((q+ + e q-)/(1 + e)) ⟂ c >= 0.

With v+ = (q+ - q)/h, v = (q - q-)/h, and Theta and phi linearised at q, this is a friction problem with the biases
(1 + e) phi/h - e n'v and Theta/h. After an impact, bodies overlap for one step and then separate with e times their speed.

Reference: Paoli and Schatzman, SIAM Journal on Numerical Analysis 40 (2002), pages 702-733.
"""

from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.stepping import Solve, Step, contacts_within_reach, free_velocity, respond, scheme


@scheme("paoli_schatzman", lacks=("friction",))
def paoli_schatzman(scene: Scene, now: Step, solve: Solve) -> Step:
    """One step of length scene.step."""
    h, e, q, v = scene.step, scene.restitution, now.q, now.v
    free = free_velocity(scene, now, v)
    contacts = contacts_within_reach(scene, q, v, free)
    bias = (1 + e) * contacts.gap / h - e * (contacts.normal @ v)
    problem = scene.friction_problem(q, free, contacts, bias=bias, joint_bias=scene.joints(q)[0] / h)
    step, v = respond("step", problem, contacts, solve)
    return Step(now.time + h, scene.moved(q, h * v), v, contacts, (step,))
