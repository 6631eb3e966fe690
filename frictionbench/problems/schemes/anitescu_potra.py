"""The time-stepping scheme of Anitescu and Potra (1997), with Poisson restitution.

    M (v+ - v) = h k + J' r + F' lam,      q+ = q + h v+,      F v+ = 0,

with Coulomb's law between the impulse r and the velocity u = J v+ at the contacts that touch at q. The constraints are on
velocities: gaps are neither anticipated nor corrected, so a body penetrates an obstacle by up to h times its speed before it is
stopped, and the drift is O(h). The bias is zero, so every LCP has a solution and no contact adds energy.

If a touching contact approaches and e > 0, an impact precedes the step (problems.schemes.impact).
"""

from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.impact import approaching, impact
from frictionbench.problems.schemes.stepping import Solve, Solved, Step, free_velocity, respond, scheme


@scheme("anitescu_potra")
def anitescu_potra(scene: Scene, now: Step, solve: Solve) -> Step:
    """One step of length scene.step."""
    h, q, v = scene.step, now.q, now.v
    contacts = scene.contacts(q)
    solved: list[Solved] = []
    if scene.restitution > 0 and approaching(scene, v, contacts).any():
        solved, v = impact(scene, q, v, contacts, solve)
    step, v = respond("step", scene.friction_problem(q, free_velocity(scene, now, v), contacts), contacts, solve)
    return Step(now.time + h, scene.moved(q, h * v), v, contacts, (*solved, step))
