"""Adapters of outside libraries beside calls by hand: the same answers. `python -m tools.direct` measures the times."""

import re

import numpy as np
import pytest

from frictionbench.problems import InputError
from frictionbench.problems.scenes import scene
from frictionbench.solvers import Status, available, find, solve
from tests.helpers.paths import ROOT
from tools.direct.__main__ import BLOCKS, FAIR, TOL, charged_table
from tools.direct.calls import CALLS
from tools.direct.given import arrays


@pytest.mark.parametrize("blocks", BLOCKS)
@pytest.mark.parametrize("spec", CALLS)
def test_a_call_by_hand_gives_the_adapters_answer(spec, blocks) -> None:
    info, _ = find(spec)
    if info.missing:
        pytest.skip(info.missing)
    problem = scene("stack", blocks=blocks, push=1.0).problem()
    by_hand, answer = CALLS[spec](arrays(problem), TOL), solve(problem, spec, tol=TOL)
    assert problem.velocity(by_hand.impulse) == pytest.approx(problem.velocity(answer.impulse), abs=1e-6)
    assert np.isfinite(by_hand.impulse).all()
    assert by_hand.clock is None or by_hand.clock > 0


def test_the_documents_say_why_an_adapter_is_charged_more() -> None:
    text = (ROOT / "docs" / "peers.md").read_text(encoding="utf-8")
    table = text.partition("<!-- begin: python -m tools.direct -->")[2]
    rows = re.findall(r"^\| ([\w\[\]=,-]+) \|(.*; [\d.]+ )\|(.*)\|$", table, re.M)
    assert {name for name, *_ in rows} <= set(CALLS)
    assert len(rows) > 10
    for name, measured, why in rows:
        ratios = [float(ratio) for ratio in re.findall(r"; ([\d.]+) ", measured)]
        assert len(ratios) == len(BLOCKS)
        assert (max(ratios) > FAIR) == bool(why.strip()), name


def test_every_library_has_a_call_by_hand() -> None:
    called = {spec.partition("[")[0] for spec in CALLS}
    assert {name for name, info in available().items() if info.needs and info.ours} == called


def test_a_planar_driver_of_siconos_is_called_once() -> None:
    """It begins at 0 whatever its guess: asking it again for more accuracy takes all its sweeps again, 1003 here."""
    spec = "siconos[method=friction_2d_nsgs]"
    if missing := find(spec)[0].missing:
        pytest.skip(missing)
    answer = solve(scene("stack", blocks=5, push=1.0).problem(), spec, tol=TOL)
    assert answer.status is Status.SOLVED
    assert answer.work["iterations"] < 700


def test_the_table_has_a_row_for_each_solver_named() -> None:
    lines = list(charged_table(["osqp", "quantecon"]))
    assert len(lines) == 4
    assert re.fullmatch(r"\| osqp\S* (\| \d+, \d+, \d+; [\d.]+ ){3}\|.*\|", lines[2])
    assert re.fullmatch(r"\| quantecon\S* (\| [^|]*)+\|", lines[3])
    with pytest.raises(InputError, match="'lemke' has no call by hand"):
        next(charged_table(["lemke"]))
