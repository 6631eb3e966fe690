"""Adapters of outside libraries beside calls by hand: the same answers. `python -m tools.direct` measures the times."""

import re

import numpy as np
import pytest

from frictionbench import instance
from frictionbench.problems import InputError
from frictionbench.problems.catalogue import problem_of, scene
from frictionbench.solvers import available, solve
from tests.helpers.friction_problems import block, installed
from tests.helpers.paths import ROOT
from tools.direct.__main__ import BLOCKS, BODIES, FAIR, TOL, charged_tables, recorded_table
from tools.direct.arrays import arrays
from tools.direct.calls import CALLS

# Within their limits of iterations, by hand or as adapters.
UNABLE = {(f"siconos[method=friction_{d}d_nsgs]", "sparse") for d in (2, 3)}
SAMPLES = {
    "plane": scene("stack", blocks=5, push=1.0).problem(),
    "sparse": scene("stack", blocks=40, push=1.0).problem(),
    "space": instance("random_bodies", contacts=10, seed=2),
    "joints": scene("chain", links=5, fall=1).problem(),
    "joints in space": problem_of("rod_chain", links=5, fall=1),
    "immobile tangents": problem_of("robot_step", case="ant-harsh-349"),
}


@pytest.mark.parametrize("sample", SAMPLES)
@pytest.mark.parametrize("spec", CALLS)
def test_a_call_by_hand_gives_the_adapters_answer(spec, sample) -> None:
    (info, _), problem = installed(spec), SAMPLES[sample]
    unmade = len(problem.joint_bias) and (CALLS[spec].by_matrix or not CALLS[spec].joints or info.refuses(problem))
    if problem.dimension not in CALLS[spec].d or problem.contacts > CALLS[spec].most or (spec, sample) in UNABLE or unmade:
        return
    by_hand, answer = CALLS[spec].function(arrays(problem), TOL), solve(problem, spec, tol=TOL)
    assert problem.velocity(by_hand.impulse) == pytest.approx(problem.velocity(answer.impulse), abs=1e-6)
    assert np.isfinite(by_hand.impulse).all()
    assert by_hand.clock is None or by_hand.clock > 0


def test_the_documents_say_why_an_adapter_is_charged_more() -> None:
    text = (ROOT / "docs" / "peers.md").read_text(encoding="utf-8")
    table = text.partition("<!-- begin: python -m tools.direct -->")[2]
    rows = re.findall(r"^\| ([\w\[\]=,-]+) \|(.*; [\d.]+.*)\|(.*)\|$", table, re.M)
    assert {name for name, *_ in rows} <= set(CALLS)
    assert len(rows) > 10
    for name, measured, why in rows:
        ratios = [float(ratio) for ratio in re.findall(r"; ([\d.]+) ", measured)]
        assert 1 <= len(ratios) <= max(len(BLOCKS), len(BODIES))
        assert (max(ratios) > FAIR) == bool(why.strip()), name


def test_every_library_has_a_call_by_hand() -> None:
    """But CVXPY's models, whose solver is clarabel's, Kamino, whose dual problem can only be overwritten as here, and PATH."""
    called = {spec.partition("[")[0] for spec in CALLS} | {"ccp_cone", "kamino", "path"}
    assert {name for name, info in available().items() if info.needs and info.ours} == called


def test_the_tables_have_a_row_for_each_solver_named(monkeypatch, tmp_path) -> None:
    monkeypatch.setattr("tools.direct.__main__.BLOCKS", (1, 5))
    monkeypatch.setattr("tools.direct.__main__.BODIES", (4,))
    monkeypatch.setattr("tools.direct.__main__.LINKS", {"chain": (3,)})
    lines = list(charged_tables(["osqp", "clarabel"]))
    assert len(lines) == 15
    assert re.fullmatch(r"\| osqp (\| \d+, \d+, \d+; [\d.]+ ){2}\|.*\|", lines[3])
    assert re.fullmatch(r"\| clarabel\S* \| \d+, \d+, \d+; [\d.]+ .*\|.*\|", lines[8])
    with pytest.raises(InputError, match="'lemke' has no call by hand"):
        next(charged_tables(["lemke"]))
    with pytest.raises(InputError, match="friction_bias"):
        arrays(block(friction_bias=[1.0]))
    with pytest.raises(InputError, match="no friction problem"):
        next(recorded_table([], tmp_path))
