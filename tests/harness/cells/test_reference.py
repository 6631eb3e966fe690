"""Reference answers are verified, failed sources give rows with a reason, and equal problems keep separate rows."""

import numpy as np
import pytest

from frictionbench.harness.cells import reference
from frictionbench.harness.cells.collect import collect
from frictionbench.harness.cells.reference import NoReference, Reference
from frictionbench.harness.cells.stored import files_of, stored_start
from frictionbench.harness.plans.plan import Source, origin
from frictionbench.problems import InputError
from frictionbench.solvers import Answer, Status
from tests.helpers.friction_problems import block, spatial
from tests.helpers.runs import run_of

MOTION = Source("stopping_block", {}, pick=3, steps=6)


@pytest.fixture
def false_claims(monkeypatch):
    """Make the given solvers return zero impulses with status SOLVED."""

    def lie(*names):
        honest = reference.solve

        def solve(problem, name, **options):
            if name in names:
                return Answer(np.zeros((problem.contacts, problem.dimension)), Status.SOLVED)
            return honest(problem, name, **options)

        monkeypatch.setattr(reference, "solve", solve)

    return lie


def test_wrong_reference_falls_back(false_claims):
    false_claims("lemke")
    answer = Reference()
    assert answer(block())[0, 0] > 0
    assert str(answer) == "path_search"
    assert Reference()(spatial(0)).any()


def test_reference_solver_is_recorded(tmp_path, false_claims):
    honest = collect(tmp_path / "honest", MOTION)
    assert {entry["reference"] for entry in honest} == {"lemke"}
    false_claims("lemke")
    others = collect(tmp_path / "false_claims", MOTION)
    assert {entry["reference"] for entry in others} == {"path_search"}
    assert [entry["step"] for entry in others] == [entry["step"] for entry in honest]


def test_motion_ends_without_reference(tmp_path, false_claims):
    false_claims(*reference.SMALL_PLANAR)
    with pytest.raises(NoReference, match=r"within 1e-08 \(lemke: .*, path_search: .*, interior_point: "):
        Reference()(block())
    with pytest.raises(InputError, match="stopping_block yields no problem: no reference answer"):
        collect(tmp_path, MOTION)


def test_failed_source_gives_skipped_rows(tmp_path):
    nothing = Source("stopping_block", {}, pick=3, steps=0)
    rows = run_of(tmp_path, "lemke", "nsgs", sources=(nothing, Source("stack", {"blocks": 2, "push": 1.0})))
    empty, full = rows[rows["problem"] == ""], rows[rows["problem"] != ""]
    assert (len(empty), len(full)) == (2, 2)
    assert set(empty["verdict"]) == {"skipped"}
    assert set(empty["scene"]) == {"stopping_block"}
    assert all("stopping_block yields no problem" in reason for reason in empty["reason"])
    assert set(full["verdict"]) == {"solved"}


def test_equal_problems_of_two_sources(tmp_path):
    sources = (Source("stack", {"blocks": 2}), Source("stack", {"blocks": 2, "push": 1.0}))
    rows = run_of(tmp_path, "lemke", "nsgs", sources=sources)
    assert rows["problem"].nunique() == 1
    assert len(rows) == 2 * 2
    first = collect(tmp_path / "starts", MOTION)[-1]
    path = next((tmp_path / "starts" / "problems").glob(f"{first['problem']}.*.starts.npz"))
    assert stored_start(tmp_path / "starts", first["problem"], origin(first), "warm") is not None
    names = [file.name for file in files_of(tmp_path / "starts", first["problem"], origin(first))]
    assert names == [f"{first['problem']}.npz", f"{first['problem']}.answer.npz", path.name]
    with pytest.raises(InputError, match="the start warm cannot be read"):
        stored_start(tmp_path / "starts", first["problem"], "another motion", "warm")
