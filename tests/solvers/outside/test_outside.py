"""Outside libraries: installed ones are tested, missing ones skipped, misbehaving ones replaced by fake libraries."""

import os
import re
import shlex

import numpy as np
import psutil
import pytest

from frictionbench.harness.cells.timing import timed_call
from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import run
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.catalogue import problem_of, scene
from frictionbench.problems.spec import parse
from frictionbench.problems.verify import verify
from frictionbench.results import store
from frictionbench.solvers import Status, available, find, plugins, solve
from frictionbench.solvers.needs import LICENSED, installed_version
from frictionbench.solvers.outside.children.child import Child, DiedError
from frictionbench.solvers.outside.mujoco import MuJoCo
from frictionbench.solvers.outside.scaled_delassus import scaled_delassus
from frictionbench.solvers.outside.siconos import perturbed
from frictionbench.solvers.pivots.dense_lcp import dense_lcp
from tests.helpers.friction_problems import block, installed, nothing, own_residual, spatial, with_joints
from tests.helpers.paths import HELPERS, ROOT
from tools.direct.page import BEGIN, FIELDS, WIDTH, facts, outcomes, page

FAKE_LIBRARIES = HELPERS / "fake_libraries.py"
SPECS = [spec for name, info in sorted(available().items()) if info.needs and name != "path" for spec in info.specs]
STACK = scene("stack", blocks=2, push=1.0).problem()
EASY = {
    "nothing": nothing(),
    "sliding": block(speed=1.0),
    "two boxes": STACK,
    "frictionless": block(friction=0.0),
    "jointed": with_joints(spatial(3, contacts=3), np.eye(1, 18)),
    "in space": spatial(1, contacts=3),
    "unlike islands given by W": FrictionProblem.from_delassus(
        np.kron(np.eye(2), STACK.W.toarray()), np.kron([1e-6, 1e-18], STACK.q), np.tile(STACK.friction, 2), 2
    ),
}
# Where these end without a solution, or without knowing that they have it: see docs/fairness.md.
UNABLE = {
    *(("casadi[settings=default]", name) for name in EASY),
    *((f"casadi[settings={settings}]", "frictionless") for settings in ("tuned", "velocities")),
    *((f"siconos[method=lcp_pivot{r}]", name) for r in ("", "_least_index") for name in ("two boxes", "jointed", "in space")),
    *(("siconos[method=friction_2d_cpg]", name) for name in ("sliding", "frictionless")),
    *((f"pinocchio[method=pgs{tuned}]", "in space") for tuned in ("", ",settings=tuned")),
    *((f"mujoco[method=cg{tuned}]", "two boxes") for tuned in ("", ",settings=tuned")),
    *((f"siconos[method={method}]", "frictionless") for method in ("lcp_pivot", "friction_3d_nsn_fb")),
    ("siconos[method=lcp_lemke]", "in space"),
    *((f"siconos[method={method}]", "two boxes") for method in ("lcp_newton_fb_fblsa", "friction_3d_dsfp")),
}


@pytest.mark.parametrize("name", EASY)
@pytest.mark.parametrize("spec", SPECS)
def test_installed_libraries_solve_easy_problems(spec, name) -> None:
    (info, _), problem = installed(spec), EASY[name]
    if reason := info.refuses(problem):
        with pytest.raises(InputError, match=reason):
            solve(problem, spec)
        return
    tol = 1e-4 if info.precision == "single" else 1e-6
    first, second = (solve(problem.fresh(), spec, tol=tol) for _ in range(2))
    assert first.impulse.shape == (problem.contacts, problem.dimension)
    assert first.work == second.work
    assert np.allclose(first.impulse, second.impulse, rtol=0, atol=1e-12)  # where its memory lies may decide the order of sums
    assert first.clock is None or first.clock >= 0
    if (spec, name) not in UNABLE:
        assert first.status is Status.SOLVED, first.detail
        assert own_residual(spec, problem, first) <= 10 * tol


@pytest.mark.parametrize("spec", SPECS)
def test_a_prepared_problem_is_solved_again_after_others(spec) -> None:
    """Templates and objects that are kept for a size hold nothing of another problem, or of the problem's earlier solve."""
    (info, solver), problem, other = installed(spec), EASY["two boxes"], scene("stack", blocks=2, push=3.0).problem()
    if not info.refuses(problem):
        prepared = solver.prepare(problem)
        first = solver.solve(prepared, 1e-4, None)
        solver.solve(solver.prepare(other), 1e-4, None)
        assert solver.solve(prepared, 1e-4, None).impulse == pytest.approx(first.impulse, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(
    ("spec", "what"),
    [
        *((spec, "chain[links=20,fall=1]") for spec in ("piqp", "ccp[backend=highs]")),
        ("proxsuite[matrices=sparse,settings=tuned]", "wall[rows=6,columns=6,friction=0.05]"),
        ("siconos[method=friction_3d_prox]", "sphere_pyramid[levels=3,noise=0.3]"),
        ("siconos[method=global_friction_3d_ipm]", "sphere_pyramid[levels=2,noise=0.3]"),
        ("casadi[settings=tuned]", "stack[blocks=5,mass_ratio=1e4,push=1]"),
        ("drake[method=unrevised,unknowns=4]", "stack[blocks=8,mass_ratio=100]"),
        ("proxsuite[matrices=sparse,settings=tuned]", "stack[blocks=3,mass_ratio=1e5]"),
        *((f"{name}[settings=tuned]", "random_bodies[contacts=8,seed=1]") for name in ("clarabel", "ccp_cone")),
        *(("pinocchio[method=admm,settings=tuned]", f"stack[blocks={blocks},push=1]") for blocks in (10, 60)),
        ("kamino[method=padmm,settings=tuned]", "random_bodies[contacts=8,seed=6]"),
    ],
)
def test_answers_are_accurate_and_accepted(spec, what) -> None:
    """Where other settings leave errors or claim failure (docs/fairness.md); ADMM on a dense and on a sparse matrix."""
    info, _ = installed(spec)
    (name, settings), tol = parse("scene", what), 1e-5 if info.precision == "single" else 1e-8
    answer = solve(problem := problem_of(name, **settings), spec, tol=tol)
    assert answer.status is Status.SOLVED
    assert own_residual(spec, problem, answer) <= tol


@pytest.mark.parametrize(
    ("spec", "what", "most"),
    [
        *(("proxsuite", f"chain[links={links},fall=1]", 9) for links in (20, 40)),
        ("siconos[method=friction_3d_admm,settings=tuned]", "stack[blocks=5,push=1]", 600),
        ("casadi[settings=tuned]", "stack[blocks=5,mass_ratio=1e2,push=1]", 60),
        ("casadi[settings=tuned]", "pyramid[rows=5,push=0.4]", 20),
    ],
)
def test_libraries_are_given_units_in_which_they_take_few_iterations(spec, what, most) -> None:
    """12, 14 and 1137 with an objective of size 1 and a mean diagonal of 1, 120 with four unknowns, 63 with tol = 1e-15."""
    installed(spec)
    name, settings = parse("scene", what)
    assert solve(problem_of(name, **settings), spec, tol=1e-8).work["iterations"] <= most


def test_osqp_does_not_look_for_packages_of_other_algebras(monkeypatch) -> None:
    """Which takes a quarter of the time charged on small problems."""
    installed("osqp")
    monkeypatch.setattr("osqp.interface.default_algebra", lambda: pytest.fail("OSQP looks for them"))
    assert solve(STACK, "osqp").status is Status.SOLVED


@pytest.mark.parametrize("spec", ["clarabel", "scs", "proxsuite", "osqp", "siconos[method=friction_2d_lemke]"])
def test_a_library_that_fails_says_so_and_prints_nothing(spec, capfd) -> None:
    installed(spec)
    answer = solve(problem_of("random", contacts=16), spec, limit=1)
    assert answer.status is Status.FAILED
    assert answer.detail
    assert answer.impulse.shape == (16, 2)
    assert capfd.readouterr().out == ""


@pytest.mark.parametrize(("rows", "d"), [((0, 1), 2), ((0, 1, 2), 2), ((0, 1, 2), 3), ((2, 0, 1), 2), ((2, 0, 1), 3)])
def test_scaled_delassus_is_E_W_E_in_the_order_asked_for(rows, d) -> None:
    problem = spatial(5) if d == 3 else scene("stack", blocks=2, push=1.0).problem()
    nc, m = problem.contacts, len(rows)
    E = np.repeat(1 / np.sqrt(problem.scale), d)
    scaled, q = E[:, None] * problem.W.toarray() * E, E * problem.q
    found = scaled_delassus(problem, rows)
    place = np.add.outer(m * np.arange(nc), rows[:d]).ravel()
    third = np.setdiff1d(np.arange(nc * m), place)
    assert found.W[np.ix_(place, place)] == pytest.approx(scaled, abs=1e-14)
    assert found.q[place] * found.theta == pytest.approx(q)
    assert found.W[third][:, third] == pytest.approx(np.diag(scaled.diagonal()[1::2][: len(third)]))
    assert not found.W[third][:, place].any()
    assert not found.q[third].any()
    impulse = np.arange(1.0 * nc * d).reshape(nc, d)
    assert found.impulse(found.guess(impulse)) == pytest.approx(impulse)


def test_share_of_the_dense_lcp_bounds_every_contacts_residual() -> None:
    """A contact that is open by far does not make the others' tolerance larger."""
    problem = scene("stack", blocks=2, push=1.0).problem()
    far = FrictionProblem.from_delassus(problem.W, problem.q + 1e6 * np.eye(1, 8, 6).ravel(), problem.friction, 2)
    near, given = dense_lcp(problem), dense_lcp(far)
    assert near.share > 0.05
    stretch, lcp = given.scaled.stretch, far.lcp()
    D = np.minimum(stretch[:4], stretch[4:12].reshape(4, 2).min(axis=1))  # theta times it
    square = stretch[3] * lcp.q[3] / given.q[3]  # theta^2
    assert given.share * square == pytest.approx((D * far.units).min())
    assert given.share < 1e-4
    assert dense_lcp(far.lcp()).share == 1


def test_a_claim_for_a_perturbed_q_holds_of_the_given_one() -> None:
    lcp = dense_lcp(scene("stack", blocks=2, push=1.0).problem())
    nudged, y = perturbed(lcp), solve(lcp.scaled.problem, "lemke").z / lcp.scaled.stretch
    ends = [given.status(z, 1e-8) for given in (lcp, nudged) for z in (y, y + 1e-3)]
    assert ends == [Status.SOLVED, Status.SOLVED, Status.SOLVED, Status.STALLED]


@pytest.mark.parametrize(("friction", "m"), [(None, 3), (0.05, 3), (0.4, 2)])
def test_whitened_rows_make_the_scaled_delassus_form(friction, m) -> None:
    """In space, in the plane with elliptic cones, and with pyramids, whose rows are n +- mu t."""
    problem = scene("stack", blocks=2, push=1.0, friction=friction).problem() if friction else spatial(5)
    (_, J, v, b, _, (counts, begins, columns, values)), dense = MuJoCo().form(problem), scaled_delassus(problem)
    if m == 2:
        edges = np.kron(np.eye(problem.contacts), [[1, friction], [1, -friction]])
    else:
        edges = np.eye(3 * problem.contacts)[:, np.arange(3 * problem.contacts) % 3 < problem.dimension]
    assert np.allclose(J @ J.T, edges @ dense.W @ edges.T, rtol=0, atol=1e-12)
    assert J @ v + b == pytest.approx(edges @ dense.q, abs=1e-12)
    compressed = np.zeros_like(J)
    compressed[np.repeat(np.arange(len(J)), counts), columns] = values
    assert np.array_equal(compressed, J)
    assert np.array_equal(begins, np.cumsum(counts) - counts)
    assert np.array_equal(counts, np.repeat(counts[::m], m))


@pytest.mark.parametrize("friction", [0.0, 0.05, 0.1, 0.4, 3.0])
def test_mujoco_states_the_softness_of_its_contacts(friction) -> None:
    """Of pyramids what verification allows; with little friction, with which pyramids stall, of elliptic cones."""
    installed("mujoco")
    for legs in (2, 6):
        answer = solve(problem := problem_of("redundant_table", speed=1.0, legs=legs, friction=friction), "mujoco", tol=1e-8)
        least = 1e-7 * np.ones(2) if friction == 0.05 else 1e-6 * np.minimum(1, (friction or 1.0) ** np.array([2, -2]))
        assert answer.softness == pytest.approx(problem.scale[:, None] * least)
        assert verify(problem, answer, "regularised", 1e-8).model_residual <= 1e-8


@pytest.mark.parametrize("spec", ["daqp", "osqp", "mujoco", "nsgs"])
def test_a_problem_is_measured_for_one_law_only(spec) -> None:
    """The units of both laws would be a third of the time charged at 2 contacts."""
    _, solver = installed(spec)
    problem = scene("stack", blocks=1, push=1.0).problem().fresh()
    solver.form(problem)
    assert len({"_measures", "_relaxed_measures"} & set(vars(problem))) == (not getattr(solver, "exact", False))


@pytest.mark.parametrize("spec", ["mujoco", "casadi"])
def test_matrices_are_compressed_before_the_solve(spec) -> None:
    (_, solver), problem = installed(spec), EASY["two boxes"]
    expected, formed = solve(problem, spec), solver.form(problem)
    prepared = solver.setup(formed)
    formed[1][:] = 0.0
    assert solver.solve(prepared, 1e-8, None).impulse == pytest.approx(expected.impulse)


@pytest.mark.parametrize("spec", ["casadi", "kamino[method=padmm]", "mujoco[method=newton]"])
def test_what_is_kept_for_a_size_is_not_timed(spec) -> None:
    _, solver = installed(spec)
    timed_call(solver, block(), lambda ready: solver.solve(ready, 3e-7, None), remote=False)  # kernels are loaded
    unseen = scene("stack", blocks=7).problem()  # of a size that no other test has
    calls = [timed_call(solver, unseen, lambda ready: solver.solve(ready, 3e-7, None), remote=False) for _ in range(2)]
    assert [call.loaded for call in calls] == [True, False]


def test_the_mixed_problem_without_its_free_unknowns_is_the_lcp() -> None:
    for problem in (EASY["two boxes"], STACK.replace(friction_bias=[0.1, 0, 0.2, 0.3]), EASY["jointed"]):
        lcp, M, q = find("path[settings=velocities]")[1].form(problem)
        whole, n = np.column_stack([M, q]), {2: 3, 3: 10}[problem.dimension] * problem.contacts
        left = np.delete(whole[:n] - M[:n, n:] @ np.linalg.solve(M[n:, n:], whole[n:]), np.s_[n:-1], axis=1)
        assert left == pytest.approx(np.column_stack([lcp.M, lcp.q]), abs=1e-12)


@pytest.mark.parametrize("info", [info for info in available().values() if info.needs], ids=lambda info: info.name)
def test_treatment_is_documented(info) -> None:
    told = facts(info).keys()
    assert told | {"Charged", "Flaws", "Law"} == set(FIELDS)
    assert told & {"Flaws", "Law"}


def test_fairness_page_is_generated() -> None:
    written = (ROOT / "docs" / "fairness.md").read_text(encoding="utf-8")
    assert written == page(), "python -m tools.direct.page"
    words = written.partition(BEGIN)[2].splitlines()
    assert [line for line in words if len(line) > WIDTH and not line.lstrip().startswith(("`", "|"))] == []  # code, tables


def test_contract_results_are_complete() -> None:
    told = outcomes()
    assert set(told) == {spec for info in available().values() if info.needs for spec in info.specs}
    assert not any(line["failed_checks"].endswith("not installed") for line in told.values())


COMMANDS = [
    (field, command, info.name)
    for field in ("Flaws", "Law", "Settings")
    for info in available().values()
    if info.needs
    for command in re.findall(r"`frictionbench ([^`]*)`", facts(info).get(field, ""))
]


@pytest.mark.parametrize(("field", "command", "name"), COMMANDS)
def test_commands_of_flaws_and_settings(field, command, name) -> None:
    """It names a problem and solvers that there are. Of flaws and other laws none has both claim and answer good; of
    settings the second solves what the first does not, or takes two thirds of its work at most."""
    verb, what, *rest = shlex.split(command)
    options = list(zip(rest[::2], rest[1::2], strict=True))
    specs, tol = [value for option, value in options if option == "--solver"], float(dict(options).get("--tol", 1e-8))
    assert (verb, {*rest[::2]} - {"--tol"}, {find(spec)[0].name for spec in specs}) == ("solve", {"--solver"}, {name})
    named, settings = parse("scene", what)
    problem, told = problem_of(named, **settings), []
    for spec in specs:
        info, solver = installed(spec)
        answer = solver.solve(solver.prepare(problem.fresh()), tol, None)
        enough = ("solved",) if field != "Settings" else ("solved", "relaxed")
        good = verify(problem, answer, info.model, tol).verdict in enough and answer.status is Status.SOLVED
        told.append((good, sum(answer.work.values())))
    if field != "Settings":
        assert not any(good for good, _ in told)
    else:
        (default, work), (tuned, less) = told
        assert tuned
        assert not default or less <= work / 1.5


def test_missing_requirements(monkeypatch) -> None:
    plugins.load(str(FAKE_LIBRARIES))
    assert find("missing_library")[0].missing == "no-such-distribution, no.such.module@/usr/bin/python3 not installed"
    with pytest.raises(InputError, match="not installed"):
        solve(block(), "missing_library")
    monkeypatch.setitem(LICENSED, "pandas", "raise SystemExit('the licence has expired')")
    assert [installed_version.__wrapped__(name) for name in ("numpy", "pandas")] == [np.__version__, None]


def test_crashed_child_is_restarted() -> None:
    child = Child(str(HELPERS / "fake_library_child.py"), os.sys.executable)
    for how, named in (("abort", "SIGABRT"), ("exit", "exit code 0")):
        with pytest.raises(DiedError, match=named):
            child.ask(do=how)
        assert child.ask(do="", n=3)["r"].tolist() == [0, 0, 0]
    child.end()


@pytest.mark.slow  # libraries that hang or end their process; the quick tests have answers only
def test_misbehaving_libraries(tmp_path) -> None:
    expected = {
        "fake_library[does=hang]": ("timeout", "limit of 2 s"),
        **{f"fake_library[does={does}]": ("wrong", "claimed solved within") for does in ("print", "child", "slow", "big")},
        "missing_library": ("skipped", "not installed"),
        "lemke": ("solved", ""),
    }
    _, files = load_plugins([str(FAKE_LIBRARIES), *expected])
    plan = Plan(
        suite="test",
        sources=(Source("stack", {"blocks": 2, "push": 1.0}),),
        solvers=tuple(expected),
        tolerances=(1e-8,),
        plugins=files,
        time_limit=2.0,
        memory_limit=2**29,
    )
    run(plan, tmp_path / "run", 1, Progress(quiet=True))
    rows = store.read_table(tmp_path / "run", "solves").set_index("variant")
    for spec, (verdict, reason) in expected.items():
        assert rows.loc[spec, "verdict"] == verdict, (spec, rows.loc[spec, "reason"])
        assert reason in (rows.loc[spec, "reason"] or ""), spec
    assert rows.loc["fake_library[does=print]", "clock_time"] == 1e-3, "the library's own clock"
    memory = rows["peak_memory"]
    assert memory["fake_library[does=big]"] - memory["fake_library[does=slow]"] > 2**26, "a child's memory counts"
    left = " ".join(part for process in psutil.process_iter(["cmdline"]) for part in process.info["cmdline"] or [])
    assert not re.search("fake_library_child|orphan of a fake library", left)
