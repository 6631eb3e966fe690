"""The steps of an engine are judged: what its impulses violate, what exact solvers answer beside it, and unusable folders."""

import json
import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import frictionbench as fb
from frictionbench.commands.judge import as_data, summary
from frictionbench.harness.judge import _net_impulses, judge_file, prepared
from frictionbench.harness.run import run
from frictionbench.problems.measures import judged, violations
from frictionbench.reports.judged import Judged
from frictionbench.reports.judgement import _shown, write_judgement
from frictionbench.results.files import ResultsError
from frictionbench.results.judgement import FILE, read_judgements
from frictionbench.results.store import read_table
from tests.helpers.browser import faults, in_browser
from tests.helpers.command_line import frictionbench
from tests.helpers.runs import quiet

STEP = 0.01
SCRIPT = "<script>alert(1)</script>"


def box(bias: float = 0.0, contacts: int = 1) -> fb.FrictionProblem:
    """A box of 2 kg that stands on contacts of friction 0.5 and is pushed by 0.05 N s; a turn is left out."""
    rows = np.tile(np.eye(2), (contacts, 1))
    free, mu = [0.025, -9.81 * STEP], np.full(contacts, 0.5)
    return fb.FrictionProblem(
        mass=2 * np.eye(2), normal=rows[1::2], tangent=rows[::2], friction=mu, free_velocity=free, bias=np.full(contacts, bias)
    )


def write_steps(folder: Path) -> None:
    weight = 2 * 9.81 * STEP
    folder.mkdir()
    fb.save(box(), folder / "exact.npz", impulse=[[weight, -0.05]], step=STEP)
    fb.save(box(), folder / "creeping.npz", impulse=[[weight, -0.046]], step=STEP, notes={"limits": 0.2, SCRIPT: 0.1})
    loaded = [[0.5503 * weight, -0.021], [0.5497 * weight, -0.021]]  # nearly alike, whose numbers on an axis would be long
    fb.save(box(contacts=2), folder / "loaded.npz", impulse=loaded, step=STEP, notes={"limits": 0.2, "x": 0.0})
    falls = box().replace(free_velocity=[0.1, -1e-15])
    fb.save(falls, folder / "falling.npz", impulse=[[2e-15, -1e-15]], step=STEP, notes={"limits": 0.9})
    fb.save(box(-0.1), folder / "deep.npz", impulse=[[weight + 2 * 0.03, -0.05]], step=STEP)
    fb.save(box(contacts=0), folder / "apart.npz", impulse=np.zeros((0, 2)), step=STEP)
    (folder / ".deep-1.npz").write_bytes(b"half-written when its program was killed")


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    home = tmp_path_factory.mktemp("judged")
    write_steps(home / "steps")
    plan, folder = prepared(home / "steps", ("nsgs",), (), 1e-8, 10.0, 1, home / "out", quiet())
    run(plan, folder, 1, quiet())
    return folder


def test_judgements(folder) -> None:
    found = {one.file: one for one in read_judgements(folder)}
    creeping, deep = found["creeping.npz"], found["deep.npz"]
    assert (creeping.law, creeping.dissipation) == ("dissipation", pytest.approx(0.002))
    assert creeping.notes == {"limits": 0.2, SCRIPT: 0.1}
    assert deep.penetration == pytest.approx(1e-3)
    assert max(found["exact.npz"].residual, deep.residual) < 1e-12  # deep: it takes 0.3 mm of the penetration away
    step = fb.load_step(folder.parent / "steps" / "creeping.npz")
    assert creeping.residual == fb.residual(judged(step), step.impulse)
    assert violations(judged(step), step.impulse).dissipation == pytest.approx([0.002])
    assert (found["apart.npz"].contacts, found["apart.npz"].residual) == (0, 0.0)
    creep = {"exact.npz": 0, "creeping.npz": pytest.approx(0.002), "deep.npz": 0, "apart.npz": None, "falling.npz": None}
    assert {name: one.known("creep") for name, one in found.items()} == creep | {"loaded.npz": pytest.approx(0.004)}
    causes = {(2e-3, 0.01): "make contacts harder", (2e-3, 0.001): "s, in creeping.npz. The likely", (2e-6, 0.1): "do, but for"}
    for (speed, soft), cause in causes.items():
        told = Judged([creeping._replace(creep=speed, notes={"softness of contacts": soft})], pd.DataFrame()).creep
        assert (cause in told, "docs/symptoms.md" in told) == (True, speed > 1e-4 * creeping.free_velocity)
    assert "inf %" in Judged([creeping._replace(free_velocity=0.0)], pd.DataFrame()).creep  # in a file of others
    steps = [creeping._replace(energy_defect=joule) for joule in (-3.0, 1.0, -2.0)]
    added, lost = (Judged(steps, pd.DataFrame()).percentiles[name] for name in ("energy_added", "energy_lost"))
    assert (added["p50"], added["worst"], lost["p50"], lost["worst"]) == (0.0, 1.0, 2.0, 3.0)


def test_a_file_and_its_folder_are_different_runs(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    fb.save(box(), path := tmp_path / "one.npz", impulse=np.zeros((1, 2)), step=STEP)
    first, _ = (prepared(each, (), (), 1e-8, 10.0, 1, None, quiet())[1] for each in (path, tmp_path))
    with pytest.raises(ResultsError, match=r"sources: one.npz\[file=one.npz\] file \w{16}.npz in the folder, test_a\S+\[file"):
        prepared(tmp_path, (), (), 1e-8, 10.0, 1, first, quiet())
    fb.save(box(), path, impulse=np.ones((1, 2)), step=STEP)  # of another engine
    assert prepared(path, (), (), 1e-8, 10.0, 1, None, quiet())[1] != first


def test_solvers_beside_answer_the_same_problems(folder) -> None:
    rows = read_table(folder, "solves")
    assert {*rows["problem"]} == {one.problem for one in read_judgements(folder) if one.contacts}
    assert [*rows["variant"].unique()] == ["hybrid", "nsgs"]
    assert rows["verdict"].value_counts().to_dict() == {"solved": 6, "unjudgeable": 2}  # falling.npz


def test_worst_steps_are_peaks_then_the_next_and_equal_steps_count(folder, monkeypatch) -> None:
    one = next(one for one in read_judgements(folder) if one.file == "creeping.npz")
    residuals = [5.0, 9.0, 8.0, 7.0, 3.0, 4.0, 4.0, *[one.floor] * 33]  # peaks: 9 and the first 4; the rest is rounding
    found = Judged([one._replace(residual=each) for each in residuals], read_table(folder, "solves").assign(time=1.0))
    slow = [one._replace(creep=0.0)] * 5
    assert "In 2 of them they creep by more than 0.01 % of it." in Judged([*slow, one, one], found.rows).creep
    assert [each.residual for each in found.worst(3)] == [9.0, 8.0, 4.0]
    assert [each.residual for each in found.worst(12)] == sorted(residuals[:7], reverse=True)
    assert [(each["variant"], each["solved"], each["steps"]) for each in found.beside] == [("hybrid", 40, 40), ("nsgs", 40, 40)]
    needless = found.rows["variant"].eq("nsgs") & found.rows["problem"].eq(one.problem)  # the zero impulse is as exact
    rows = found.rows.assign(trivial=needless, verdict=found.rows["verdict"].mask(needless, "unjudgeable"))
    steps = [one._replace(contradiction="..."), *(each for each in read_judgements(folder) if each.file == "deep.npz")]
    assert [(each["solved"], each["steps"]) for each in Judged(steps, rows).beside] == [(2, 2), (1, 1)]
    monkeypatch.setattr("frictionbench.commands.judge.read_judged", lambda _: Judged(steps, rows))
    assert "\nleft out of the solvers' rows, as no impulse is needed: 1 step\n" in summary(folder)
    assert as_data(folder)["impossible"].startswith("1 of 2 steps has no solution")


def test_summary_and_page(folder, monkeypatch) -> None:
    monkeypatch.setattr("frictionbench.commands.table.screen", lambda: 60)
    text = summary(folder)
    assert "residual worst  time p50  time worst" in text  # heads are whole words on a narrow terminal
    assert text.startswith("steps: 5 steps with contacts judged by Coulomb's law, 1 without contact")
    assert "law violated most: dissipation in 1, signorini in 1, none beyond rounding in 3" in text
    words = " ".join(text.split())
    told = ("creep at 2 mm/s, 2 % of", "median of 4 of 5 steps; at up to 4 mm/s, 4 %, in loaded", "limits 20 % in 2 steps")
    assert all(each in words for each in (*told, "10 % in 1 step solved"))  # and none of 0 %
    assert "Left out: 1 step without impulses beyond rounding. Net impulses between bodies within 1 % of the" in words
    assert "Without the impulse that stops the creep the rest is <0.01 %, within 1 % for 1 more; at most 8.9 %, in" in words
    page = write_judgement(folder).read_text(encoding="utf-8")
    assert not any(word in page for word in (SCRIPT, "mathdefault"))  # ticks are text
    words = ("nsgs", "none beyond rounding in 3 steps.", "Dissipation: co", "Judged: steps, 5", "energy lost, J", "<svg")
    assert all(word in page for word in words)


def test_edited_judgements_are_refused(folder, tmp_path) -> None:
    row = next(row for row in json.loads((folder / FILE).read_text()) if row["contacts"])
    for change in ({"law": "__class__"}, {"residual": float("nan")}, {"net_impulses": {"0": [1.0] * 7}}, {"contacts": "x"}):
        (tmp_path / FILE).write_text(json.dumps([row | change]))
        with pytest.raises(ResultsError, match=FILE):
            read_judgements(tmp_path)


def test_a_link_is_replaced_by_what_is_judged(folder, tmp_path, monkeypatch) -> None:
    """Also where the folder is not on the file system of temporary files, so that these cannot be renamed."""
    stored, other = next((folder / "judged").iterdir()), tmp_path / "other"
    stored.unlink()
    stored.symlink_to(other)
    monkeypatch.setattr(os, "rename", lambda *_: os.stat(""))
    prepared(folder.parent / "steps", ("nsgs",), (), 1e-8, 10.0, 1, folder, quiet())
    assert not other.exists()


def test_a_step_without_solution_is_named(tmp_path) -> None:
    """A driven joint pushes the box into the floor with 1 m/s, beside a step that can be solved."""
    for name, steps in (("pressed.npz", box().replace(joints=[[0.0, 1.0]], joint_bias=[1.0])), ("free.npz", box())):
        fb.save(steps, tmp_path / name, impulse=np.zeros((1, 2)), step=STEP)
    found = [judge_file(tmp_path, tmp_path / name) for name in ("free.npz", "pressed.npz")]
    assert [bool(one.contradiction) for one in found] == [False, True]
    assert Judged(found[:1], pd.DataFrame()).impossible == ""
    told = Judged(found, pd.DataFrame()).impossible
    assert told.startswith("1 of 2 steps has no solution, with proof; pressed.npz: no solution exists")
    assert "contact 0 and joint equation 0" in told


def test_unusable_folders_are_refused(tmp_path) -> None:
    steps = tmp_path / "steps"
    write_steps(steps)
    fb.save(box(), steps / "problem.npz")
    (tmp_path / "diverged").mkdir()
    fb.save(box(), tmp_path / "diverged" / "last.npz", impulse=[[1e308, 1e308]], step=STEP)
    (tmp_path / "empty").mkdir()
    for name, told_of in (
        ("none", "folder: there is no folder or file none"),
        ("empty", "folder: empty holds no steps"),
        ("steps", "problem.npz: holds a problem, but not"),
        ("diverged", "last.npz: impulse: an entry of 1e+100 N s or more overflows"),
    ):
        done = frictionbench("judge", name, "--jobs", "1", cwd=tmp_path)
        assert (done.returncode, done.stdout) == (2, "")
        assert told_of in done.stderr
    assert not (tmp_path / "runs").exists()


def test_what_seems_to_be_a_mistake_is_told(tmp_path, monkeypatch) -> None:
    """A file without the step's length, and forces in place of impulses."""
    impulse = np.array([[2 * 9.81 * STEP, -0.05]])
    fb.save(box(), tmp_path / "timeless.npz", impulse=impulse)
    fb.save(box(), tmp_path / "forces.npz", impulse=impulse / STEP, step=STEP)
    timeless, forces = (
        Judged([judge_file(tmp_path, tmp_path / name)], pd.DataFrame()) for name in ("timeless.npz", "forces.npz")
    )
    assert timeless.doubts == "1 of 1 steps do not say their length `step`: penetration counts as a violation. "
    assert (forces.doubts[:46], "likely cause" in forces.creep) == ("In most steps the impulses are worse than none", False)
    monkeypatch.setattr("frictionbench.harness.judge.find", lambda _: (SimpleNamespace(missing="x not installed"), None))
    with pytest.raises(fb.InputError, match=r"^against: x not installed"):
        prepared(tmp_path, ("nsgs",), (), 1e-8, 10.0, 1, None, quiet())


def test_hyperstatic_contacts_are_marked(tmp_path) -> None:
    """Of a box on three feet that cannot turn, the sum of the impulses is determined and none of them alone."""
    each = np.array([[2 * 9.81 * STEP, -0.05]]) / 3
    fb.save(box(contacts=3), tmp_path / "feet.npz", impulse=np.repeat(each, 3, axis=0) * [[1.0], [1.2], [0.8]], step=STEP)
    one = judge_file(tmp_path, tmp_path / "feet.npz")
    net = one.net_impulses["0 to 1"]
    assert (net.contacts, net.determined, net.each_determined) == (3, True, False)
    assert max(net.difference, net.without_creep) < 1e-6
    assert net.engine + net.exact == pytest.approx([-0.05, 2 * 9.81 * STEP] * 2)
    assert _shown(net._replace(engine=[-1e-20, 1.0]))["engine"] == "0, 1"
    idle = box(contacts=2).replace(tangent=[[1.0, 0.0], [0.0, 0.0]])  # the second contact bears only what rounding leaves
    assert _net_impulses(idle, np.array([[1.0, 0.0], [0.0, 0.0]]), np.array([[1.0, 0.0], [1e-39, 0.0]]))["1"].difference < 1e-12
    assert _net_impulses(box().replace(bias=[1.0]), np.array([[1e-15, 0.0]]), np.zeros((1, 2)))["0 to 1"].difference < 1e-5
    dry = box(contacts=2).replace(normal=[[0.0, 1.0], [0.0, 0.0]])  # the second is dry friction of a joint
    assert [*_net_impulses(dry, np.ones((2, 2)), np.ones((2, 2)))] == ["0 to 1"]
    assert "In 1 of 1 the forces of single contacts are not determined (hyperstatic)" in Judged([one], pd.DataFrame()).forces


@in_browser
def test_page_looks(folder) -> None:
    assert faults(write_judgement(folder)) == []
