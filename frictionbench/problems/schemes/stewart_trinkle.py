"""The time-stepping scheme of Stewart and Trinkle (1996), with constraints on gaps and Poisson restitution.

    M (v+ - v) = h k + J' r + F' lam,      q+ = q + h v+,      F v+ + Theta/h = 0,

with Coulomb's law between r and u = J v+ + phi/h e_n at all contacts within reach of the step. The linearised gaps are
nonnegative at the end of the step, and a contact that remains open has no impulse. The drift is O(h^2). If all gaps are
nonnegative, every LCP has a solution. An overlap phi < 0 is corrected at the speed |phi|/h, which adds the energy -c phi/h.
If a body overlaps with two opposite walls, there may be no solution.

The scheme reduces the approach velocity of a body so that its gap just closes. If e > 0 and a contact would close within the
step, an impact over the remaining gap therefore precedes it; restitution then acts up to one step early.

Bodies that face each other corner to corner have no contact until they overlap, because their normal is not determined and a
wrong one would stop bodies that pass each other.
"""

from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes.impact import approaching, impact
from frictionbench.problems.schemes.stepping import Solve, Solved, Step, contacts_within_reach, free_velocity, respond, scheme


@scheme("stewart_trinkle")
def stewart_trinkle(scene: Scene, now: Step, solve: Solve) -> Step:
    """One step of length scene.step."""
    h, q, v = scene.step, now.q, now.v
    free = free_velocity(scene, now, v)
    contacts = contacts_within_reach(scene, q, v, free)
    solved: list[Solved] = []
    if scene.restitution > 0:
        closing = contacts.gap + h * (contacts.normal @ free) < scene.touch
        hitting = contacts.only(closing | (contacts.gap <= scene.touch))
        if approaching(scene, v, contacts.only(closing)).any():
            solved, v = impact(scene, q, v, hitting, solve)
            free = free_velocity(scene, now, v)
            contacts = contacts_within_reach(scene, q, v, free)
    theta = scene.joints(q)[0]
    problem = scene.friction_problem(q, free, contacts, bias=contacts.gap / h, joint_bias=theta / h)
    step, v = respond("step", problem, contacts, solve)
    return Step(now.time + h, scene.moved(q, h * v), v, contacts, (*solved, step))
