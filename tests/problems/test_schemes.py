"""The schemes, what they refuse, and driving a scene through time."""

from dataclasses import replace
from functools import partial
from math import radians

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.catalogue import scene, scenes
from frictionbench.problems.check import Array
from frictionbench.problems.planar.bodies import half_plane, rigid_box, rigid_disc
from frictionbench.problems.residual import residual
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes import SCHEMES, NoSolution, Step, start
from frictionbench.problems.schemes.anitescu_potra import anitescu_potra
from frictionbench.problems.simulate import simulate
from tests.helpers import friction_problems

lemke = partial(friction_problems.lemke, tol=1e-10)


def last(made: Scene, steps: int | None = None) -> Step:
    *_, step = simulate(made, lemke, steps=steps)
    return step


def ball(height: float = 0.5, speed: float = 0.0, e: float = 0.0, friction: float = 0.0, step: float = 0.01) -> Scene:
    """A disc of radius .5 over the ground."""
    return Scene(
        bodies=(rigid_disc(0.5),),
        obstacles=(half_plane(),),
        q0=np.array([0, height, 0]),
        v0=np.array([0, speed, 0]),
        friction=friction,
        restitution=e,
        step=step,
    )


def test_free_fall_solves_an_empty_problem() -> None:
    made = ball(height=100.0)
    step = last(made, steps=10)
    assert [(s.phase, s.problem.contacts) for s in step.solved] == [("step", 0)]
    assert step.v[1] == pytest.approx(-9.81 * 0.1)
    assert step.q[1] == pytest.approx(100 - 9.81 * 0.01**2 * 55)  # h v+ summed
    assert step.time == pytest.approx(0.1)


def test_phases_of_a_step() -> None:
    assert [s.phase for s in last(ball(speed=-1.0, e=0.5), 1).solved] == ["compression", "decompression", "step"]
    assert [s.phase for s in last(ball(speed=-1.0), 1).solved] == ["step"]
    assert [s.phase for s in last(ball(e=0.5), 1).solved] == ["step"]  # at rest: no impact


def test_decompression_friction() -> None:
    """A spinning disc that hits the ground: in each phase it gains speed mu times the normal impulse, until it rolls."""
    made = ball(speed=-1.0, e=0.5, friction=0.1)
    made = replace(made, v0=np.array([0, -1.0, -100.0]))
    step = anitescu_potra(made, start(made), lemke)
    compression, decompression, _ = step.solved
    mass = made.bodies[0].mass
    assert decompression.problem.friction_bias == pytest.approx([0.1 * 0.5 * mass])
    assert compression.impulse[0, 1] == pytest.approx(0.1 * mass)
    assert decompression.impulse[0, 1] == pytest.approx(0.1 * 0.5 * mass)


def test_simulate_covers_the_duration() -> None:
    steps = list(simulate(scene("stopping_block", duration=0.2), lemke))
    assert len(steps) == 21
    assert steps[-1].time == pytest.approx(0.2)
    assert steps[0].solved == ()
    assert steps[0].contacts.feature.tolist() == steps[-1].contacts.feature.tolist()


SMALL = {"stack": {"blocks": 3}, "wall": {"rows": 2, "columns": 2}, "pyramid": {"rows": 2}}


STEPPING = {name: scheme for name, scheme in SCHEMES.items() if not scheme.events}


@pytest.mark.parametrize("name", scenes())
def test_every_scheme_on_every_scene(name: str) -> None:
    refused, unsolved = set(), set()
    made = scene(name, **SMALL.get(name, {}))
    for label, scheme in STEPPING.items():
        reason = scheme.refuses(made)
        if reason:
            refused.add(label)
            with pytest.raises(InputError, match=r"^scheme: it has no law of"):
                scheme(made, start(made), lemke)
            continue
        try:
            *_, end = simulate(made, lemke, scheme, steps=4)
        except NoSolution:
            unsolved.add(label)
        else:
            assert end.time == pytest.approx(4 * made.step)
            assert np.isfinite(end.q).all()
    refused -= {n for n in refused if STEPPING[n].lacks and n not in ("lotstedt", "paoli_schatzman")}  # a contributor's
    assert refused == {n for n, law in (("lotstedt", made.restitution), ("paoli_schatzman", made.friction)) if law > 0}
    assert unsolved == ({"acceleration"} if name == "painleve_rod" else set())


@pytest.mark.parametrize("name", [name for name in STEPPING if name != "paoli_schatzman"])
@pytest.mark.parametrize("example", ["stack", "pyramid"])
def test_rest_is_preserved_by_every_scheme(name: str, example: str) -> None:
    made = scene(example, **SMALL[example], push=0.0)
    *_, end = simulate(made, lemke, SCHEMES[name], steps=20)
    assert end.q == pytest.approx(made.q0, abs=1e-8)
    assert end.v == pytest.approx(made.v0, abs=1e-8)
    weight = 9.81 * made.step * sum(body.mass for body in made.bodies)
    assert end.solved[-1].impulse[end.contacts.bodies[:, 1] == -1, 0].sum() == pytest.approx(weight)


@pytest.mark.parametrize("name", ["anitescu_potra", "stewart_trinkle", "acceleration"])
def test_mirror_invariance(name: str) -> None:
    """A tilted block thrown to the right or to the left falls, rebounds and slides on a slope that falls that way."""

    def thrown(sign: float) -> Scene:
        return Scene(
            bodies=(rigid_box(1, 2),),
            obstacles=(half_plane(slope=-0.2 * sign),),
            q0=np.array([0, 1.3, sign * radians(20)]),
            v0=np.array([sign, 0, 0]),
            friction=0.4,
            restitution=0.3,
        )

    runs = (simulate(thrown(sign), lemke, SCHEMES[name], steps=100) for sign in (1, -1))
    for right, left in zip(*runs, strict=True):
        assert left.q * [-1, 1, -1] == pytest.approx(right.q, abs=1e-7)


def test_wrong_answer_does_not_judge_scheme() -> None:
    """A belt that stops where the law does not ask for it says nothing about forces."""
    made = scene("painleve_rod", friction=0.2, tip_velocity=-3.0)

    def seizing(problem: FrictionProblem) -> Array:
        stuck = np.linalg.solve(problem.W.toarray(), -problem.q)
        return stuck.reshape(1, 2)

    step = SCHEMES["acceleration"](made, start(made), seizing)
    assert residual(step.solved[-1].problem, step.solved[-1].impulse) > 0.1
