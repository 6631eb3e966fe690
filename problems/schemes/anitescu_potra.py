"""The time-stepping scheme of Anitescu and Potra (1997), with Poisson restitution.

    M (v+ - v) = h k + J' r + F' lam,      q+ = q + h v+,      F v+ = 0,

with Coulomb's law between the impulse r and the velocity u = J v+ at the contacts that touch at q. It works on velocities: a
gap is neither anticipated nor corrected, so a body enters an obstacle by up to h times its speed before it is stopped, and
the drift is O(h). The bias is zero, so every problem has a solution and no contact ever adds energy.

Where a touching contact approaches (it would close by more than scene.touch within the step) and e > 0, an impact goes first,
in two phases without external forces (Anitescu and Potra 1997, section 3). Compression brings the contacts to rest with
impulses whose normal parts are c. Decompression returns e c, and whatever impulses (x, y) it takes to keep the contacts
apart, with friction bounded by the whole impulse, |y| <= mu (x + e c). With one e for all contacts, the energy after an
impact is at most that before less (1 - e^2)/2 |p|^2 in the metric of M^-1, p the compression impulse.
"""

from problems.scene import Scene
from problems.schemes.stepping import Solve, Solved, Step, respond


def anitescu_potra(scene: Scene, now: Step, solve: Solve) -> Step:
    """One step of length scene.step."""
    h, q, v = scene.step, now.q, now.v
    contacts = scene.contacts(q)
    solved: list[Solved] = []
    if scene.restitution > 0 and (h * (contacts.normal @ v) < -scene.touch).any():
        compression, v = respond("compression", scene.friction_problem(q, v, contacts), solve)
        returned = scene.restitution * compression.impulse[:, 0].clip(min=0)
        thrown = v + (contacts.normal.T @ returned) / scene.weights
        rebound = scene.friction_problem(q, thrown, contacts, friction_bias=scene.friction * returned)
        decompression, v = respond("decompression", rebound, solve)
        solved += [compression, decompression]
    free = v + h * scene.force(q, v, now.time) / scene.weights
    step, v = respond("step", scene.friction_problem(q, free, contacts), solve)
    return Step(now.time + h, q + h * v, v, contacts, (*solved, step))
