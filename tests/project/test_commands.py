"""Every command of the README and of docs is executed: as it stands, or on less where it would take longer than a test may.

Those of docs/executable.md need its files and are in test_executable.py, those of docs/fairness.md in tests/solvers/outside.
"""

import re
import shlex
import shutil
import socket
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest

from frictionbench.harness.workers import cluster
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.recorded.native import EngineStep, save
from frictionbench.results.store import read_table
from tests.helpers.command_line import frictionbench
from tests.helpers.paths import ROOT

pytestmark = pytest.mark.slow  # the quick tests read the documents, and would not see a command that fails as it stands
APART = ("peers.md", "executable.md", "fairness.md")
DOCS = ROOT / "docs"
FIRST = [ROOT / "README.md", DOCS / "choose.md", DOCS / "plugin.md"]  # they make what later commands use
DOCUMENTS = [*FIRST, *sorted(path for path in DOCS.glob("*.md") if path.name not in APART and path not in FIRST)]
# What stands for the words in capitals of a synopsis, whose options are all given, and of several choices the first.
STANDS_FOR = {
    "[--jobs N]": "--jobs 1",
    "[--scene S]": "",
    "[--solver A]": "--solver lemke",
    "[--time-limit S]": "",
    "[--out DIR]": "--out runs/synopsis",
    "[SUITE]": "smoke",
    "SUITE": "smoke",
    "ADDRESS": "tcp://127.0.0.1:8786",
    "run batch --out DIR": "run batch --out runs/batch",
    "BASELINE": "baselines/smoke.tsv",
    "FILE.hdf5": "made.hdf5",
    "FILE|SCENE": "problem.npz",
    "SCENE|DIR": "two_blocks",
    "DIR|fclib/FAMILY": "FOLDER",
    "--data DIR": "--data FOLDER",
    "fclib/FAMILY": "fclib/Chain",
    "FILE|NAME": "mine.py",
    "SCENE[...]": "stack[blocks=2]",
    "SCENE": "stack",
    "[--paper [--solvers A,B] [--scenes A,B]]": "--paper",
    "DIR": "runs/now",
    "--solver NAME": "--solver lemke",
    "FILE": "problem.npz",
}
# What is added, by how a command begins, unless it is named in the command: fewer problems, solvers, steps.
ON_LESS = {
    "run standard": (
        "--scene 'stack[blocks=2,push=1]'",
        "--solver lemke --solver nsgs --solver interior_point",
        "--tol 1e-6",
        "--out runs/standard",
    ),
    "run --config": ("--scene 'stack[blocks=2]'",),
    "run smoke": ("--scene 'random_bodies[contacts=8,friction=100]'", "--tol 1e-6"),
    "run spatial": ("--scene 'sphere_pyramid[levels=1]'", "--solver nsgs", "--tol 1e-4"),
    "run robots": ("--scene 'robot_step[case=humanoid-settle-269]'", "--solver nsgs"),
    "run batch": ("--scene 'stack[blocks=1]'", "--solver lemke"),
    "run maps": ("--scene redundant_table", "--solver lemke"),
    "run hard": ("--scene stack", "--solver lemke"),
    "run recorded": ("--solver lemke",),
    "run replay": ("--solver lemke",),
    "solve": ("--solver lemke",),
    "rerun": ("--solver mine.py",),
    "show": ("--steps 3",),
    "map": ("--solver lemke", "--time-limit 1"),
}
GRID = ":30", ":16", ":13"  # along an axis of a map; a test has two
# Commands that need a network, a cluster, fetched data or a row: what is said where there is none.
REFUSED = {
    "export fclib/": "Chain",
    "run recorded --data fclib": "frictionbench export fclib",
    "run standard --cluster": "cluster",
    "run smoke --cluster": "cluster",
}


def commands(text: str) -> list[str]:
    """The commands of a document: indented lines without their remarks, and those in a line of text."""
    found = re.findall(r"^    frictionbench (.+?)(?:\s+# .*)?$|`frictionbench ([^`\n]+ [^`\n]+)`", text, re.MULTILINE)
    return [own for pair in found for own in pair if own]


def executable(command: str, row: str) -> str:
    """A command with words in place of those in capitals, on less."""
    for name, value in STANDS_FOR.items():
        command = command.replace(name, value)
    command = re.sub(r"\[(--[^\]]*)\]", r"\1", command)  # optional parts
    command = re.sub(r"(?<=[\w/])\|[\w|/]+", "", command)  # further choices
    command = re.sub(r"\bROW\b", row, command)
    for count in GRID:
        command = re.sub(rf"{count}\b", ":2", command)
    added = next((options for start, options in ON_LESS.items() if command.startswith(start)), ())
    return " ".join([command, *(option for option in added if option.split()[0] not in command)])


@pytest.fixture(scope="module")
def newcomer(tmp_path_factory) -> Path:
    """A folder with what the pages have one write: a plug-in, a problem, a folder of steps; and an earlier run."""
    home = tmp_path_factory.mktemp("newcomer")
    blocks = re.findall(r"```python\n(.*?)```", (DOCS / "plugin.md").read_text(encoding="utf-8"), flags=re.DOTALL)
    plugin = next(block for block in blocks if "@solver" in block)
    (home / "solvers").mkdir()
    for path in (home / "mine.py", home / "solvers" / "mine.py"):
        path.write_text(plugin, encoding="utf-8")
    (config,) = re.findall(r"```toml\n(.*?)```", (DOCS / "commands.md").read_text(encoding="utf-8"), flags=re.DOTALL)
    (home / "run.toml").write_text(config, encoding="utf-8")
    problem = random_problem(1, contacts=2)
    for name in ("problem.npz", "FOLDER/step_0001.npz", "FOLDER/step_0002.npz"):
        (home / name).parent.mkdir(exist_ok=True)
        save(problem, home / name)
    EngineStep(problem, np.zeros((2, 2))).save(home / "steps")
    return home


@pytest.fixture
def no_network(monkeypatch) -> None:
    """No name is resolved, and no scheduler answers."""
    monkeypatch.setattr(socket, "getaddrinfo", Mock(side_effect=socket.gaierror("no network")))
    monkeypatch.setattr(cluster, "ANSWER_SECONDS", 0.5)


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_commands_of_a_document(document: Path, newcomer: Path, no_network) -> None:
    """Each ends with exit code 0, or is refused with exit code 2 and the word that tells why."""
    row, failed = "", []
    for command in commands(document.read_text(encoding="utf-8")):
        if "ROW" in command and not row:
            row = first_failure(newcomer)
        ran = executable(command, row)
        if ran.startswith("run smoke") and "--out runs/now" in ran:  # made by this document, not by an earlier one
            shutil.rmtree(newcomer / "runs" / "now", ignore_errors=True)
        for made in re.findall(r"-o (\S+)", ran):
            (newcomer / made).unlink(missing_ok=True)
        ended = frictionbench(*(word for word in shlex.split(ran) if "*" not in word), cwd=newcomer)
        refused = next((why for start, why in REFUSED.items() if ran.startswith(start)), "")
        if ended.returncode != (2 if refused else 0) or refused not in ended.stderr:
            failed.append(f"frictionbench {ran}\n{ended.stdout}\n{ended.stderr}")
    assert not failed, "\n".join(failed)


def first_failure(newcomer: Path) -> str:
    """The row of a failed cell of a small run, made anew in runs/now."""
    shutil.rmtree(newcomer / "runs" / "now", ignore_errors=True)
    options = shlex.split(" ".join(ON_LESS["run smoke"]))
    frictionbench("run", "smoke", "--solver", "mine.py", *options, "--out", "runs/now", cwd=newcomer)
    rows = read_table(newcomer / "runs" / "now", "solves")
    return str(rows.loc[np.argmax(rows["verdict"] != "solved"), "key"])


def test_figure_of_ones_own(newcomer, monkeypatch) -> None:
    """The script of docs/figures.md draws the run that the commands before it made."""
    (script,) = re.findall(r"```python\n(.*?)```", (DOCS / "figures.md").read_text(encoding="utf-8"), flags=re.DOTALL)
    monkeypatch.chdir(newcomer)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    drawn: dict[str, Any] = {}
    exec(script, drawn)
    assert (newcomer / "within.pdf").stat().st_size > 1000
    labels = [text.get_text() for text in drawn["figure"].legends[0].get_texts()]
    assert labels == ["interior_point", "lemke", "nsgs"]
    lemke = drawn["ax"].lines[1]
    assert lemke.get_ydata()[-1] == 1
