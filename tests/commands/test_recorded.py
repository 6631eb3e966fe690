"""The commands solve, export and run on problem files and instances."""

import json

import h5py
import numpy as np
import pytest

from frictionbench.commands import single
from frictionbench.commands.export import export
from frictionbench.commands.shrink import shrink
from frictionbench.commands.single import rerun_row, solve_one
from frictionbench.harness.plans.choose import RunOptions, choose
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import run
from frictionbench.problems import InputError
from frictionbench.problems.catalogue import make_instance, scene as make_scene
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.recorded import fclib, native, read
from frictionbench.reports.page import write_report
from frictionbench.reports.recorded import recorded_problems
from frictionbench.reports.run import read_run
from frictionbench.results.store import read_table
from frictionbench.solvers import solve
from tests.helpers.friction_problems import spatial


def test_file_is_solved_and_ranked(tmp_path, capsys) -> None:
    fclib.write(spatial(0, contacts=3), tmp_path / "p.hdf5")
    solve_one(str(tmp_path / "p.hdf5"), ["nsgs", "interior_point", "osqp"], 1e-8, 10.0, 1)
    told = capsys.readouterr().out
    assert "3 contacts" in told
    assert told.splitlines()[-1].startswith("fastest on this problem: ")
    assert told.splitlines()[-2].split()[:2] == ["3", "osqp:"]  # planar only: skipped, and so last


def test_export(tmp_path) -> None:
    (path,) = export("cubes[boxes=2,friction=0.3]", tmp_path / "cubes.hdf5")
    assert read(path).hash == make_instance("cubes", boxes=2, friction=0.3).hash
    several = export("stack[blocks=2,push=1]", tmp_path / "stack", pick=2)
    assert [read(path).contacts for path in several] == [4, 4]
    with pytest.raises(InputError, match=r"^out: .* exists; it was not overwritten"):
        list(export("cubes[boxes=2,friction=0.3]", tmp_path / "cubes.hdf5"))
    with pytest.raises(InputError, match=r"^out: 2 problems need a folder"):
        list(export("stack[blocks=2,push=1]", tmp_path / "stack.hdf5", pick=2))


@pytest.mark.slow  # a spatial problem, which other rows are not
def test_rerun_and_shrink_spatial_row(tmp_path) -> None:
    plan = choose(RunOptions("spatial", ["cubes[boxes=2,mass_ratio=1e6,push=1]"], tol="1e-8"), ("nsgs[relaxation=0.01]",))
    run(plan, tmp_path, 1, Progress())
    (key,) = read_table(tmp_path, "solves")["key"]
    row, again = rerun_row(tmp_path, key, [])
    assert row["verdict"] == again["verdict"] == "unsolved"
    assert again["residual"] == row["residual"]
    path, small, *_ = shrink(tmp_path, key, [])
    assert read(path).hash == small.hash
    assert (small.dimension, small.contacts < 8) == (3, True)


def test_run_of_bare_lcps(tmp_path) -> None:
    """Beside a friction problem, whose headlines they do not enter; their rows are run again like any."""
    data, out = tmp_path / "set", tmp_path / "out"
    data.mkdir()
    np.savez(data / "lcp.npz", M=[[2.0, 1.0], [1.0, 2.0]], q=[-5.0, -6.0])
    fclib.write(random_problem(1, contacts=4), data / "whole.hdf5")
    run(choose(RunOptions("recorded", tol="1e-8", data=[str(data)]), ("nsgs", "lemke")), out, 1, Progress())
    rows = read_table(out, "solves").set_index(["size", "variant"])
    assert rows["verdict"].value_counts().to_dict() == {"solved": 3, "skipped": 1}
    assert rows["verdict"][(2, "nsgs")] == "skipped"
    lcp = rows.loc[(2, "lemke")]
    assert np.isnan(lcp["contacts"])
    assert lcp["solve_time"] > 0
    _, again = rerun_row(out, lcp["key"], [])
    assert (again["verdict"], again["residual"]) == ("solved", lcp["residual"])
    ours = read_run(out)
    assert ours.ranked["size"].tolist() == [16, 16]
    told = recorded_problems(ours)
    assert [(line["contacts"], line["unknowns"], list(line["solvers"])) for line in told[:1]] == [(None, 2, ["lemke"])]
    assert "LCP, n = 2" in write_report(out).read_text(encoding="utf-8")
    assert sorted(path.suffix for path in export(str(out), tmp_path / "again")) == [".hdf5", ".npz"]


def test_stored_guess_is_warm_start(tmp_path) -> None:
    data, out = tmp_path / "set", tmp_path / "out"
    data.mkdir()
    problem = random_problem(1, contacts=4)
    for name, guess in (("good", solve(problem, "lemke", tol=1e-12).impulse), ("zero", np.zeros((4, 2)))):
        path = data / f"{name}.hdf5"
        fclib.write(problem, path)
        with h5py.File(path, "a") as file:
            file["guesses/number_of_guesses"] = np.array([1], dtype=np.int32)
            file["guesses/1/r"] = guess.ravel()
    run(choose(RunOptions("recorded", tol="1e-8", data=[str(data)]), ("nsgs", "lemke")), out, 1, Progress())
    rows = read_table(out, "solves")
    sweeps = rows[rows["variant"] == "nsgs"].set_index(["parameters", "start"])["work"].map(json.loads)
    assert [start for _, start in sweeps.index] == ["cold", "warm", "cold"], "a guess of zeros is a cold start"
    cold, warm = sweeps.iloc[0]["sweeps"], sweeps.iloc[1]["sweeps"]
    assert warm < cold


def test_unreadable_files_give_skipped_rows(tmp_path) -> None:
    data, out = tmp_path / "set", tmp_path / "out"
    data.mkdir()
    np.savez(data / "lcp.npz", M=np.eye(2), q=np.ones(2))
    (data / "torn.dat").write_text("3\n4\n")
    fclib.write(random_problem(1, contacts=4), data / "whole.hdf5")
    run(choose(RunOptions("recorded", tol="1e-8", data=[str(data)]), ("nsgs",)), out, 1, Progress())
    lcp, torn, whole = read_table(out, "solves").to_dict("records")
    assert (lcp["verdict"], torn["verdict"], whole["verdict"]) == ("skipped", "skipped", "solved")
    assert lcp["reason"] == "nsgs solves friction problems, not bare LCPs"
    assert "torn.dat: read as the text of Siconos: contacts: 4 is out of range" in torn["reason"]
    with pytest.raises(InputError, match=r"^row: .* has no problem to run again: .*torn\.dat"):
        rerun_row(out, torn["key"], [])


def test_files_in_order_are_a_sequence(tmp_path) -> None:
    """Every step but the first, and one after a step with another number of contacts, is started from the step before."""
    pushed = make_scene("stack", blocks=3, push=1.0).problem()
    *steps, last = (pushed.replace(free_velocity=pushed.free_velocity * faster) for faster in (1, 1.01, 1.02, 1.03))
    problems = [*steps, make_scene("stack", blocks=2, push=1.0).problem(), last]
    names = ["step_1.npz", "step_2.npz", "step_3.npz", "step_9.npz", "step_10.npz"]
    data, out = tmp_path / "set", tmp_path / "out"
    data.mkdir()
    for name, problem in zip(names, problems, strict=True):
        native.save(problem, data / name)
    (data / ".step_1-1.npz").write_bytes(b"half-written when its program was killed")
    run(choose(RunOptions("replay", tol="1e-8", data=[str(data)]), ("nsgs",)), out, 1, Progress())
    rows = read_table(out, "solves")
    started = rows.groupby("step")["start"].agg(list).to_dict()
    assert started == {0: ["cold"], 1: ["cold", "warm"], 2: ["cold", "warm"], 3: ["cold"], 4: ["cold"]}
    assert rows["parameters"].map(json.loads).map(lambda one: one["file"]).unique().tolist() == names
    assert (rows["verdict"] == "solved").all()
    sweeps = rows.set_index(["step", "start"])["work"].map(lambda work: json.loads(work)["sweeps"])
    assert sweeps[1, "warm"] < sweeps[1, "cold"]
    assert set(rows.loc[rows["start"] == "warm", "reference"]) == {"lemke"}


@pytest.mark.parametrize(
    ("suite", "scenes", "complaint"),
    [
        ("recorded", ["stack"], "names the problems to run, and so does --scene"),
        ("standard", [], "standard has problems of its own"),
        ("replay", [], "no problems in .*: no .hdf5, .h5, .dat, .npz file"),
    ],
)
def test_unusable_data(tmp_path, suite, scenes, complaint) -> None:
    with pytest.raises(InputError, match=f"^data: {complaint}"):
        choose(RunOptions(suite, scenes, data=[str(tmp_path)]), ("nsgs",))


def test_first_answer_is_told_before_the_table(capsys, monkeypatch) -> None:
    monkeypatch.setattr(single, "ANNOUNCED_AFTER", 0.0)
    solve_one("stack[blocks=1]", ["lemke", "nsgs"], 1e-6, 10.0, 1)
    told = capsys.readouterr().err.splitlines()
    assert [line.split(" solves it")[0] for line in told if "the table follows" in line] == ["nsgs"]
    solve_one("stack[blocks=1]", ["lemke"], 1e-6, 10.0, 1)
    assert "the table follows" not in capsys.readouterr().err
    with pytest.raises(InputError, match=r"^solver: osqp: .*; nsgs\[precision=single\]: single prec"):  # not asked for less
        solve_one("cubes[boxes=1]", ["osqp", "nsgs[precision=single]"], 1e-8, 10.0, 1)
