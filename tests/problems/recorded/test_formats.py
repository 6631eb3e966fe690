"""Each file format is read correctly, and damaged or malicious files are rejected with the name of the bad field."""

import zlib
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy import sparse

from frictionbench.problems import LCP, InputError
from frictionbench.problems.instances.cubes import cubes
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.recorded import fclib, forms, read
from frictionbench.problems.residual import residual
from frictionbench.solvers import solve
from tests.helpers.friction_problems import known_by_W, spatial, with_joints
from tests.helpers.recorded import FOLDER, blocks, columns, dense, numbers, recorded, triplets

PLANAR, SPATIAL = random_problem(3, contacts=4, bodies=2), spatial(5, contacts=3)
BOTH = pytest.mark.parametrize("problem", [PLANAR, SPATIAL], ids=["planar", "spatial"])


@BOTH
@pytest.mark.parametrize("write", [dense, triplets, columns, blocks], ids=lambda write: write.__name__)
def test_siconos_text_of_a_local_problem(tmp_path, problem, write) -> None:
    matrix = write(problem.W, problem.dimension) if write is blocks else write(problem.W)
    path = tmp_path / "problem.dat"
    text = f"{problem.dimension}\n{problem.contacts}\n{matrix}{numbers(problem.q)}\n{numbers(problem.friction)}\n\na remark\n"
    path.write_text(text, encoding="ascii")
    assert read(path).hash == known_by_W(problem).hash


@BOTH
@pytest.mark.parametrize("write", [dense, triplets, columns], ids=lambda write: write.__name__)
def test_siconos_text_of_a_global_problem(tmp_path, problem, write) -> None:
    path = tmp_path / "problem.dat"
    offset = [x for b in problem.bias for x in (b, *[0] * (problem.dimension - 1))]
    vectors = "\n".join(map(numbers, (problem.mass @ problem.free_velocity, offset, problem.friction)))
    matrices = write(problem.mass) + write(problem.jacobian.T.tocsr())
    path.write_text(f"{problem.dimension}\n{problem.contacts}\n{matrices}{vectors}\n", encoding="ascii")
    found = read(path)
    assert found.mechanical
    for name in ("mass", "normal", "tangent"):
        assert abs(getattr(found, name) - getattr(problem, name)).nnz == 0
    assert np.array_equal(found.bias, problem.bias)
    assert np.allclose(found.free_velocity, problem.free_velocity, rtol=1e-15)


@pytest.mark.parametrize("write", [dense, lambda M: blocks(M, 2), triplets], ids=["dense", "blocks", "triplets"])
def test_siconos_text_of_an_lcp(tmp_path, write) -> None:
    M, q = sparse.csr_array([[2.0, 1, 0, 0], [0, 3, 0, 1], [1, 0, 1, 0], [0, 0, 5, 1]]), np.array([-1.0, 2, -3, 4])
    path = tmp_path / "lcp.dat"
    path.write_text(f"4\n{write(M)}{numbers(q)}\n\n# a remark", encoding="ascii")
    found = read(path)
    assert isinstance(found, LCP)
    assert found.hash == LCP(M, q).hash


@BOTH
@pytest.mark.parametrize("form", ["mechanical", "joints", "known by W"])
def test_fclib_round_trip(tmp_path, problem, form) -> None:
    nv = len(problem.free_velocity)
    problem = {
        "mechanical": problem,
        "joints": with_joints(problem, np.random.default_rng(0).standard_normal((2, nv))),
        "known by W": known_by_W(problem),
    }[form]
    fclib.write(problem, tmp_path / "p.hdf5", "title", "description")
    found, _ = fclib.read(tmp_path / "p.hdf5")
    assert found.hash == problem.hash == read(tmp_path / "p.hdf5").hash


def fclib_file(path: Path, form: str, matrices: dict, vectors: dict, d: int, storage: int) -> None:
    """A file as others write it, in any of the three storages."""
    with h5py.File(path, "w") as file:
        file[f"{form}/spacedim"] = np.array([d], dtype=np.int32)
        for name, matrix in matrices.items():
            M = {0: matrix.tocoo, -1: matrix.tocsc, -2: matrix.tocsr}[storage]()
            p, i = (M.col, M.row) if storage == 0 else (M.indptr, M.indices)
            sizes = {"m": M.shape[0], "n": M.shape[1], "nz": M.nnz if storage == 0 else storage, "nzmax": M.nnz}
            for part, value in (sizes | {"p": p, "i": i}).items():
                file[f"{form}/{name}/{part}"] = np.atleast_1d(value).astype(np.int32)
            file[f"{form}/{name}/x"] = M.data
        for name, vector in vectors.items():
            file[f"{form}/vectors/{name}"] = vector
        file["guesses/number_of_guesses"] = np.array([1], dtype=np.int32)
        file["guesses/1/r"] = np.full(len(vectors["mu"]) * d, 0.5)


@pytest.mark.parametrize("storage", [0, -1, -2], ids=["triplets", "columns", "rows"])
@BOTH
def test_fclib_storages_and_joints_of_a_local_problem(tmp_path, problem, storage) -> None:
    """W, V, R from the mechanics; eliminating the joints gives the jointed problem's W and q."""
    F = np.random.default_rng(1).standard_normal((2, len(problem.free_velocity)))
    F = np.vstack([F, F[0] - F[1]])  # redundant
    jointed, d = with_joints(problem, F), problem.dimension
    inverse, J, F = problem.inverse_mass, problem.jacobian, sparse.csr_array(F)
    matrices = {"W": problem.W, "V": sparse.csr_array(J @ inverse @ F.T), "R": sparse.csr_array(F @ inverse @ F.T)}
    vectors = {"q": problem.q, "mu": problem.friction, "s": F @ problem.free_velocity}
    fclib_file(tmp_path / "p.hdf5", "fclib_local", matrices, vectors, d, storage)
    found, guesses = fclib.read(tmp_path / "p.hdf5")
    assert np.allclose(found.W.toarray(), with_joints(problem, F).W.toarray(), atol=1e-10)
    q = J @ jointed.velocity(np.zeros(problem.contacts * d)) + (problem.q - J @ problem.free_velocity)
    assert np.allclose(found.q, q, atol=1e-10)
    assert np.array_equal(guesses[0], np.full((problem.contacts, d), 0.5))


@BOTH
def test_global_problem_reduced_to_W(tmp_path, problem) -> None:
    d, nv = problem.dimension, len(problem.free_velocity)
    M = sparse.csr_array(problem.mass + sparse.csr_array(([0.1], ([0], [1])), shape=(nv, nv)))
    H, w = sparse.csr_array(problem.jacobian.T), np.arange(problem.contacts * d) / 10
    f = np.ones(nv)
    for mass, offset in ((M, np.zeros(len(w))), (problem.mass, w)):
        matrices, vectors = {"M": mass, "H": H}, {"f": f, "w": offset, "mu": problem.friction}
        fclib_file(tmp_path / "p.hdf5", "fclib_global", matrices, vectors, d, 0)
        found, inverse = read(tmp_path / "p.hdf5"), np.linalg.inv(mass.toarray())
        assert not found.mechanical
        assert np.allclose(found.W.toarray(), H.T @ inverse @ H.toarray(), atol=1e-10)
        assert np.allclose(found.q, H.T @ inverse @ f + offset, atol=1e-10)


def test_global_problem_without_bodies(tmp_path) -> None:
    matrices = dict.fromkeys(("M", "H"), sparse.csr_array((0, 0)))
    fclib_file(tmp_path / "p.hdf5", "fclib_global", matrices, dict.fromkeys(("f", "w", "mu"), np.zeros(0)), 3, 0)
    assert read(tmp_path / "p.hdf5").summary == "0 contacts in space, 0 velocities"


def test_contactbench_axis_order(tmp_path) -> None:
    order = np.array([1, 2, 0, 4, 5, 3, 7, 8, 6])
    G = SPATIAL.W.toarray()[np.ix_(order, order)]
    np.savez(tmp_path / "p.npz", G=G, g=SPATIAL.q[order][:, None], mus=SPATIAL.friction, lam0=np.zeros((9, 1)))
    assert read(tmp_path / "p.npz").hash == known_by_W(SPATIAL).hash


@pytest.mark.parametrize("local", [True, False], ids=["local", "global"])
def test_large_problems_are_sparse(tmp_path, monkeypatch, local) -> None:
    """2000 contacts; a dense matrix of their size would be asked of numpy's eigenvalues, or of toarray."""

    def refuse(*_, **__):
        raise AssertionError("a matrix was made dense")

    problem = cubes(500, push=1.0)
    fclib.write(known_by_W(problem) if local else problem, tmp_path / "p.hdf5")
    monkeypatch.setattr(sparse.csr_array, "toarray", refuse)
    monkeypatch.setattr(np.linalg, "eigh", refuse)
    found = read(tmp_path / "p.hdf5")
    assert residual(found, solve(found, "hybrid").impulse) <= 1e-8


# Bad files. Each is a good one with one thing changed, and the field that the error has to name.

LOCAL = {
    "fclib_local/spacedim": [np.array([4], dtype=np.int32), np.array([3.5]), None],
    "fclib_local/W/m": [np.array([10**9], dtype=np.int64), np.array([-1]), None, np.array([2, 2])],
    "fclib_local/W/nz": [np.array([-7]), None],
    "fclib_local/W/i": [np.full(48, 99, dtype=np.int32), np.full(48, -1, dtype=np.int32), np.ones(48), None, np.zeros(1, int)],
    "fclib_local/W/p": [np.zeros(3, dtype=np.int32), np.full(10, -1, dtype=np.int32), np.arange(10)[::-1], None],
    "fclib_local/W/x": [np.full(48, np.nan), np.ones((2, 2)), None],
    "fclib_local/vectors/q": [np.full(9, np.inf), np.zeros(8), np.zeros((9, 1)), None, np.bytes_(b"text")],
    "fclib_local/vectors/mu": [np.full(3, -1.0), np.zeros(7), None],
}


@contextmanager
def edited_fclib(folder: Path):
    """A good file, open to be changed."""
    fclib.write(known_by_W(SPATIAL), folder / "p.hdf5")
    with h5py.File(folder / "p.hdf5", "a") as file:
        yield file


@pytest.mark.parametrize(("field", "value"), [(field, value) for field, values in LOCAL.items() for value in values])
def test_bad_fclib_field(tmp_path, field, value) -> None:
    """It is named, or another in which it shows."""
    with edited_fclib(tmp_path) as file:
        del file[field]
        if value is not None:
            file[field] = value
    last = field.rpartition("/")[2]
    named = {"m": "m|W", "x": "x|W", "i": "i|W", "p": "p|W", "mu": "mu|friction|q"}.get(last, last)
    with pytest.raises(InputError, match=rf"p\.hdf5: ([\w/]*/)?({named}): "):
        read(tmp_path / "p.hdf5")


def virtual(vectors: h5py.Group, elsewhere: Path) -> None:
    layout = h5py.VirtualLayout(shape=(9,), dtype=float)
    layout[:] = h5py.VirtualSource(str(elsewhere), "q", shape=(9,))
    vectors.create_virtual_dataset("q", layout)


def bomb(vectors: h5py.Group, elsewhere: Path) -> None:
    vectors.create_dataset("q", (10**9,), float, chunks=(10**6,), compression="gzip")[:10] = 1.0


def chunk(vectors: h5py.Group, elsewhere: Path) -> None:
    """Nine numbers, for which a chunk of 1 GiB would be unpacked."""
    made = vectors.create_dataset("q", (9,), float, maxshape=(None,), chunks=(2**27,), compression="gzip")
    made.id.write_direct_chunk((0,), zlib.compress(bytes(8)))


def external(vectors: h5py.Group, elsewhere: Path) -> None:
    vectors.create_dataset("q", (9,), float, external=[(str(elsewhere.with_name("raw")), 0, 72)])


HOSTILE_Q = {  # links and objects in the place of q that readers must not follow
    "external link": lambda vectors, elsewhere: vectors.update(q=h5py.ExternalLink(str(elsewhere), "q")),
    "soft link": lambda vectors, elsewhere: vectors.update(q=h5py.SoftLink("/fclib_local/vectors/mu")),
    "external storage": external,
    "virtual": virtual,
    "bomb": bomb,
    "chunk": chunk,
    "foreign filter": lambda vectors, elsewhere: vectors.create_dataset("q", data=SPATIAL.q, chunks=(9,), compression="lzf"),
    "cube": lambda vectors, elsewhere: vectors.update(q=np.zeros((2, 2, 2))),
    "never written": lambda vectors, elsewhere: vectors.create_dataset("q", (9,), float),
}
HOSTILE_FILES = {  # and what is told of other hostile things
    "a/b/c": lambda file: file.create_group("/".join("abcdefghij")),
    "many": lambda file: file.update({f"many/{k}": 1.0 for k in range(1100)}),
    r"a\\x1b\[31m\\n: is a link": lambda file: file.update({"a\x1b[31m\n": h5py.SoftLink("/x")}),
    ".*(groups are nested more|more than 1000)": lambda file: file.update({"fclib_local/loop": file["/"]}),
}


@pytest.mark.parametrize("kind", HOSTILE_Q)
def test_malicious_fclib_vector_is_refused(tmp_path, kind) -> None:
    with h5py.File(tmp_path / "elsewhere.hdf5", "w") as file:
        file["q"] = SPATIAL.q
    (tmp_path / "raw").write_bytes(SPATIAL.q.tobytes())
    with edited_fclib(tmp_path) as file:
        del file["fclib_local/vectors/q"]
        HOSTILE_Q[kind](file["fclib_local/vectors"], tmp_path / "elsewhere.hdf5")
    with pytest.raises(InputError, match=r"p\.hdf5: fclib_local/vectors/q"):
        read(tmp_path / "p.hdf5")


@pytest.mark.parametrize("told", HOSTILE_FILES)
def test_malicious_fclib_file_is_refused(tmp_path, told) -> None:
    with edited_fclib(tmp_path) as file:
        HOSTILE_FILES[told](file)
    with pytest.raises(InputError, match=rf"p\.hdf5: {told}"):
        read(tmp_path / "p.hdf5")


def test_names_within_hdf5_may_be_those_of_arguments_of_savez(tmp_path) -> None:
    with edited_fclib(tmp_path) as file:
        file["file"] = file["allow_pickle"] = np.ones(2)
    assert read(tmp_path / "p.hdf5").hash == known_by_W(SPATIAL).hash


def test_matrices_that_are_needed_dense_are_bounded() -> None:
    n = 2**20
    w = np.zeros(n)
    w[1] = 1.0  # on a tangential velocity: the local form is made, from a dense H
    with pytest.raises(InputError, match=rf"^H: of shape \({n}, {n}\) is needed dense"):
        forms.from_global(sparse.eye_array(n, format="csr"), sparse.csr_array((n, n)), np.ones(n), w, np.zeros(n // 2), 2)


def test_crash_of_hdf5_library(tmp_path, monkeypatch) -> None:
    path = tmp_path / "p.hdf5"
    fclib.write(known_by_W(SPATIAL), path)
    monkeypatch.setattr(fclib, "MAX_SECONDS", 1e-3)
    with pytest.raises(InputError, match="reading was aborted after"):
        read(path)
    monkeypatch.undo()
    monkeypatch.setattr(fclib, "MAX_BYTES", -(2**26))  # too little memory to live in
    with pytest.raises(InputError, match=r"p\.hdf5: "):
        read(path)
    with pytest.raises(OSError, match=r"28\] No space left"):  # by Python: at a full disk the library may end the process
        fclib.write(known_by_W(SPATIAL), Path("/dev/full"))


W4 = "0\n4\n4\n4 4\n" + "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n"
BAD_TEXT = {
    "claims": ("2\n2\n0\n1000000000\n1000000000\n1000000000 1000000000\n1", "first matrix, rows"),
    "claims blocks": ("2\n2\n1\n4\n4\n9999999\n2\n2\n", "first matrix, number of blocks"),
    "claims triplets": ("2\n2\n2\n4\n4\n1\nCSparse\ntriplet: 4-by-4, nzmax: 9 nnz: 99999999\n 0 0 : 1\n", "first matrix"),
    "not d nc": ("2\n3\n" + W4 + "1.5 1 1 1\n.5 .5 .5", "W"),
    "cut in q": ("2\n2\n" + W4 + "1.5 1", "q"),
    "not a number": ("2\n2\n" + W4 + "1.5 1 1 1\n.5 half", "mu"),
    "NaN": ("2\n2\n" + W4 + "1.5 nan 1 1\n.5 .5", "q"),
    "indefinite": ("2\n2\n" + W4.replace("0 1 0 0 0 0 1", "0 1 0 0 0 0 -1") + "1.5 1 1 1\n.5 .5", "W"),
    "index": ("2\n2\n2\n4\n4\n1\nCSparse\ntriplet: 4-by-4, nzmax: 9 nnz: 1\n 0 9 : 1\n1.5 1 1 1\n.5 .5", "first matrix"),
    "long word": ("2\n2\n" + "1" * 3_000_000, "text"),
    "block pattern": ("2\n2\n1\n4\n4\n1\n2\n2\n2 4\n2 4\n3 1\n0 1 1\n7\n0\n1 0 0 1\n", "first matrix, block pattern"),
    "long count": (f"2\n2\n2\n4\n4\n1\nCSparse\ntriplet: 4-by-4, nzmax: 9 nnz: {'9' * 5000}\n 0 0 : 1\n", "first matrix"),
    "endless": ("2\n1\n2\n2\n2\n2\nCSparse\n2-by-2, nzmax: 1 nnz: 1, 1-norm: 1\n col 0 : locations 0 to inf\n", "first matrix"),
    "lcp cut": ("3\n0\n3\n3\n3 3\n1 0 0 0 1 0 0 0 1\n1 1", "q"),
}


@pytest.mark.parametrize("name", BAD_TEXT)
def test_bad_text(tmp_path, name) -> None:
    text, field = BAD_TEXT[name]
    path = tmp_path / "p.dat"
    path.write_text(text, encoding="ascii")
    with pytest.raises(InputError, match=rf"p\.dat: read as the text of Siconos: {field}.*: "):
        read(path)


def test_unknown_files(tmp_path) -> None:
    (tmp_path / "none.npz").touch()
    (tmp_path / "part.npz").write_bytes(b"PK\x03\x04 and nothing more")
    np.save(tmp_path / "one.npy", np.ones(3))
    np.savez(tmp_path / "p.npz", a=np.ones(3))
    told = {"nothing.npz": "no such file", ".": "not a regular file", "none.npz": "is empty", "part.npz": "not an .npz file"}
    for name, reason in (told | {"p.npz": "holds a; expected", "one.npy": "holds one array"}).items():
        with pytest.raises(InputError, match=f"{tmp_path / name}: {reason}"):
            read(tmp_path / name)


# Problems of other projects, where they are at hand.


@pytest.mark.parametrize("path", recorded("reference"))
def test_reference_impulses_solve_recorded_problems(path) -> None:
    """The reference impulses, of other programs, solve the problem that is read: rows, signs and storage are as they meant."""
    name = path.name.removesuffix(".ref.npz").removeprefix("contactbench_")
    problem = read(next(p for p in (FOLDER / "friction").iterdir() if p.name in (name, name + ".npz")))
    with np.load(path) as stored:
        assert residual(problem, stored["r"].reshape(problem.contacts, -1)) <= 1e-10  # in the unit of the slowest island
