"""The page in a browser, narrow, wide and printed, light and dark, with few solvers and many: no text overlaps or is cut, axe
finds it accessible, nothing is asked for, nothing goes wrong, every chart is drawn."""

import json
from pathlib import Path

import numpy as np
import pytest

from frictionbench.reports.charts import CHARTS
from frictionbench.reports.page import write_report
from frictionbench.reports.run import read_run
from tests.helpers.browser import audited, in_browser
from tests.helpers.made_results import simulation_row, solve_row, unanswered_row, write_folder


def folder_of(path: Path, solvers: int) -> Path:
    """Solvers of all kinds of names on a scene of six sizes and two others, one of them trivial; one claims falsely."""
    random = np.random.default_rng(0)
    names = [*("lemke", "nsgs", "ccp[backend=clarabel]"), *(f"method_{i}[relaxation=1.{i}]" for i in range(solvers - 3))]
    rows, simulations = [], []
    for i, name in enumerate(names):
        for k, contacts in enumerate((1, 2, 5, 12, 40, 150)):
            for tol in (1e-4, 1e-6, 1e-8):
                time = 1e-5 * (i + 1) * contacts ** (0.5 + 0.1 * (i % 9)) * random.uniform(0.8, 1.2)
                facts = {"contacts": contacts, "size": 4 * contacts, "rank": 2 * contacts - k, "family": f"f{i % 4}"}
                facts |= {"sensitivity": 10.0**k, "backward_error": tol, "work": json.dumps({"pivots": k + i})}
                facts |= {"parameters": json.dumps({"blocks": contacts})}
                facts |= {"clock_time": time / (1 + i % 2), "solve_time": time, "key": f"{name} {k} {tol}"}
                rows.append(solve_row(name, f"p{k}", tol, residual=tol * random.uniform(1e-3, 1), **facts))
        rows.append(solve_row(name, "w", scene="a_long_name_of_a_scene", family=f"f{i % 4}"))
        rows.append(solve_row(name, "t", scene="jam", trivial=True))
        rises = [2.0, 2.0 + 10.0 ** -(1 + i), 2.0 + 10.0 ** -(1 + i)]
        simulations += [simulation_row(name), simulation_row(name, scene="rise", energies=rises, key=f"rise {name}")]
    rows[3] |= {"verdict": "wrong", "residual": 3.21e-3, "reason": "claims a residual within 1e-08, has 0.0032"}
    rows.append(unanswered_row("lemke", "x", "timeout", scene="a_long_name_of_a_scene"))
    rows.append(unanswered_row("nsgs", "y", "skipped", scene="other"))
    return write_folder(path / f"run{solvers}", rows, simulations)


@in_browser
@pytest.mark.parametrize("solvers", [3, 30])
def test_no_text_overlaps(tmp_path, solvers):
    folder = folder_of(tmp_path, solvers)
    found = audited(write_report(folder), accessible=solvers == 3)  # axe takes minutes for many
    assert [fault for view in found for fault in view["faults"]] == []
    assert {view["dark"] for view in found} == {False, True}
    run = read_run(folder)
    panels = sum((1 + chart.ranked) * len(chart.panels(run)[chart.on_page]) for chart in CHARTS.values())
    assert {view["drawn"] for view in found} == {panels}


@in_browser
def test_audit_detects_faults(tmp_path):
    report = write_report(write_folder(tmp_path / "run", [solve_row("a", "p")]))
    text = '<text x="9" y="20">one</text><text x="12" y="20">two</text><text x="190" y="20">three is far too long</text>'
    bad = f'<svg width="200" height="40">{text}</svg><img src="nowhere.png"><div style="width: 1500px">wide</div>'
    report.write_text(report.read_text(encoding="utf-8").replace("</header>", f"</header>{bad}"), encoding="utf-8")
    for view in audited(report):
        for fault in ("overlap: two and one", "outside its drawing: three is far too long", "image-alt", "the page is 15"):
            assert any(found.startswith(fault) for found in view["faults"]), fault
