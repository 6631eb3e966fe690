"""Problem files that someone edited are read, or refused in one line that names the file; nothing else happens.

A few cases by default; FRICTIONBENCH_MUTATIONS=1000 runs more.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from frictionbench.problems import LCP, FrictionProblem, InputError
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.recorded import fclib, own, read
from frictionbench.problems.recorded.own import EngineStep, packed
from frictionbench.problems.scenes import scene
from tests.helpers.edits import CASES, edited_array, little_memory, little_time, mutated
from tests.helpers.friction_problems import known_by_W, spatial, with_joints
from tests.helpers.recorded import blocks, columns, dense, global_text, local_text, numbers, triplets

pytestmark = pytest.mark.slow  # edits at random; the quick tests see those that are listed by name

PLANAR, SPATIAL = random_problem(3, contacts=4, bodies=2), spatial(5, contacts=3)
BARE = LCP(np.eye(3) + 0.1, [-1.0, 2.0, -3.0])
BY_W = known_by_W(SPATIAL)
STEP = EngineStep(SPATIAL, np.ones((3, 3)), {"limits": 0.25, "soft contacts": 0.5}, 0.01)
JOINTED = with_joints(PLANAR, np.random.default_rng(0).standard_normal((2, len(PLANAR.free_velocity))))
TEXTS = {
    "dense": local_text(PLANAR, dense(PLANAR.W)),
    "blocks": local_text(SPATIAL, blocks(SPATIAL.W, 3)),
    "triplets": local_text(PLANAR, triplets(PLANAR.W)),
    "columns": local_text(PLANAR, columns(PLANAR.W)),
    "global": global_text(SPATIAL, columns),
    "lcp": f"3\n{triplets(BARE.M)}{numbers(BARE.q)}\n",
}
PLAIN = {
    "M": np.eye(2),
    "N": np.array([[1.0, 0.0], [0.5, 1.0]]),
    "T": np.array([[0.0, 1.0], [1.0, 0.0]]),
    "mu": np.array([0.5, 0.3]),
    "v": np.array([-1.0, 1.0]),
    "b": np.zeros(2),
    "d": np.array(2),
    "F": np.array([[1.0, 1.0]]),
    "bF": np.zeros(1),
}
CONTACTBENCH = {"G": SPATIAL.W.toarray(), "g": SPATIAL.q[:, None], "mus": SPATIAL.friction, "lam0": np.zeros((9, 1))}
WORDS = ("-1", "0", "3", "4", "1000000000", "99999999999999999999", "inf", "nan", "1e300", "-2.5", "x", ":", "9" * 5000, "2,")


def is_read_or_refused(path: Path) -> None:
    """Assert it, in little time; other errors propagate."""
    with little_time():
        told = complaint(path)
    assert told is None or (told.startswith(str(path)) and "\n" not in told), told


def complaint(path: Path) -> str | None:
    """Why the file is refused, None where it is not."""
    try:
        read(path)
    except InputError as error:
        return str(error)
    return None


def archived(problem: FrictionProblem | LCP, path: Path) -> dict[str, np.ndarray]:
    own.save(problem, path)
    with np.load(path) as stored:
        return dict(stored)


@pytest.mark.parametrize("kind", ["mechanical", "jointed", "by W", "lcp", "engine step", "plain", "contactbench"])
def test_edited_archives(tmp_path, kind) -> None:
    random, path = np.random.default_rng(4), tmp_path / "problem.npz"
    made = {"mechanical": scene("stack", blocks=2).problem(), "jointed": JOINTED, "by W": BY_W, "lcp": BARE}
    made["engine step"] = SPATIAL
    arrays = {"plain": PLAIN, "contactbench": CONTACTBENCH}[kind] if kind not in made else archived(made[kind], path)
    if kind == "engine step":
        arrays |= packed(STEP)
    with little_memory():
        for _ in range(CASES):
            name = list(arrays)[random.integers(len(arrays))]
            np.savez(path, **arrays | {name: edited_array(arrays[name], random)})
            is_read_or_refused(path)


@pytest.mark.parametrize("kind", TEXTS)
def test_edited_texts(tmp_path, kind) -> None:
    random, path, words = np.random.default_rng(5), tmp_path / "problem.dat", TEXTS[kind].split(" ")
    with little_memory():
        for _ in range(CASES):
            content = list(words) if random.random() < 0.3 else TEXTS[kind].split()
            for _ in range(random.integers(1, 3)):
                content[random.integers(min(len(content), 40))] = WORDS[random.integers(len(WORDS))]
            path.write_text(" ".join(content), encoding="utf-8")
            is_read_or_refused(path)


@pytest.mark.parametrize("problem", [PLANAR, JOINTED, BY_W], ids=["global", "joints", "local"])
def test_edited_arrays_of_hdf5(tmp_path, monkeypatch, problem) -> None:
    random, path = np.random.default_rng(6), tmp_path / "problem.hdf5"
    fclib.write(problem, path)
    arrays = fclib._unpack(path)
    with little_memory():
        for _ in range(CASES):
            name = list(arrays)[random.integers(len(arrays))]
            changed = edited_array(arrays[name], random)
            if changed.dtype.kind not in "fiu":  # of these hdf5_child passes on no other
                continue
            monkeypatch.setattr(fclib, "_unpack", lambda _, changed=changed, name=name: arrays | {name: changed})
            is_read_or_refused(path)


@pytest.mark.parametrize("write", [own.save, fclib.write], ids=["npz", "hdf5"])
def test_mutated_bytes(tmp_path, write: Callable[[FrictionProblem, Path], None]) -> None:
    random, path = np.random.default_rng(7), tmp_path / "problem"
    made = tmp_path / f"made.{'npz' if write is own.save else 'hdf5'}"
    write(PLANAR, made)
    content = made.read_bytes()
    with little_memory():
        for _ in range(CASES if write is own.save else (CASES + 1) // 2):
            path.write_bytes(mutated(content, random))
            is_read_or_refused(path)
