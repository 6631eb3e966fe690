"""Whatever the package is built from, it is whole: a checkout, an sdist, a ZIP archive without links.

The wheel is used in an environment of its own, from elsewhere, where nothing but a scratch folder can be written.
"""

import json
import os
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

from tests.helpers.paths import ROOT

pytestmark = pytest.mark.slow  # builds; the quick tests use the checkout, and would not see that a package is empty
BUILD = "import sys; from setuptools import build_meta; getattr(build_meta, sys.argv[1])(sys.argv[2])"
SUBPACKAGES = "problems", "solvers", "harness", "results", "reports", "commands"
MODULES = {".".join(path.relative_to(ROOT).with_suffix("").parts) for path in (ROOT / "frictionbench").rglob("*.py")}


def build(kind: str, source: Path, out: Path) -> Path:
    """Build "wheel", "editable" or "sdist" of a source tree, as a build frontend does, and return the one file made."""
    subprocess.run([sys.executable, "-c", BUILD, f"build_{kind}", str(out)], cwd=source, check=True, capture_output=True)
    (made,) = out.iterdir()
    return made


def source_tree(home: Path) -> Path:
    """A copy of what is built, with the links at the root."""
    (home / "source").mkdir(parents=True)
    shutil.copytree(ROOT / "frictionbench", home / "source" / "frictionbench", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, home / "source")
    for name in SUBPACKAGES[:5]:
        (home / "source" / name).symlink_to(f"frictionbench/{name}")
    return home / "source"


def from_sdist(source: Path) -> Path:
    """The source tree that the sdist of a source tree holds."""
    shutil.unpack_archive(build("sdist", source, source.parent / "sdists"), source.parent / "unpacked", filter="data")
    (unpacked,) = (source.parent / "unpacked").iterdir()
    return unpacked


def from_zip(source: Path) -> Path:
    """The source tree as a ZIP archive holds it, unpacked by Python: links are text files."""
    for name in SUBPACKAGES[:5]:
        (source / name).unlink()
        (source / name).write_text(f"frictionbench/{name}", encoding="utf-8")
    return source


ORIGINS = {"checkout": lambda source: source, "sdist": from_sdist, "zip": from_zip}


@pytest.mark.parametrize("origin", ORIGINS)
def test_wheel_holds_all_modules(origin: str, tmp_path: Path) -> None:
    wheel = build("wheel", ORIGINS[origin](source_tree(tmp_path)), tmp_path / "wheels")
    with zipfile.ZipFile(wheel) as held:
        names = [Path(name) for name in held.namelist()]
    assert {".".join(name.with_suffix("").parts) for name in names if name.suffix == ".py"} == MODULES
    data = {
        path.relative_to(ROOT)
        for path in (ROOT / "frictionbench").rglob("*")
        if path.suffix in (".tsv", ".npz", ".csv", ".bib")
    }
    published = {path for path in data if "published" in path.parts}
    assert data - published <= set(names)


@pytest.fixture(scope="module")
def installed(tmp_path_factory) -> Path:
    """An environment with the wheel and the dependencies of this one, but not this checkout. Its path has spaces."""
    home = tmp_path_factory.mktemp("a folder with spaces")
    environment = home / "an environment"
    wheel = build("wheel", source_tree(home), home / "wheels")
    shutil.rmtree(home / "source")
    venv.create(environment, symlinks=True)
    (site,) = environment.glob("lib/python*/site-packages")
    shutil.unpack_archive(wheel, site, "zip")
    others = [entry for entry in sys.path if Path(entry).name == "site-packages"]
    (site / "dependencies.pth").write_text("\n".join(others), encoding="utf-8")
    (environment / "no folder").touch()
    for folder in {path.parent for path in (site / "frictionbench").rglob("*.py")}:
        (folder / "__pycache__").touch()  # where a folder cannot be made: root may write whatever its mode
    return environment


def python(environment: Path, code: str, *arguments: str, **asked: str) -> subprocess.CompletedProcess:
    """Run it from another directory, by a user whose home cannot be made and whose packages cannot be written to.

    The directory is full of packages of the same names as ours.
    """
    elsewhere = environment.parent / "else where"
    for name in SUBPACKAGES:
        (elsewhere / name).mkdir(parents=True, exist_ok=True)
        (elsewhere / name / "__init__.py").write_text("raise ImportError('not ours')", encoding="utf-8")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "XDG_", "NUMBA_CACHE"))}
    command = [environment / "bin" / "python", "-P", "-c", code, *arguments]
    asked |= {"HOME": str(environment / "no folder" / "home"), "TMPDIR": str(elsewhere), "COLUMNS": "200", "PYTHONPATH": ":"}
    return subprocess.run(command, cwd=elsewhere, env=kept | asked, capture_output=True, text=True, check=False, timeout=300)


COMMANDS = """
import json, sys
from frictionbench.commands.cli import main
for arguments in json.loads(sys.argv[1]):
    sys.argv[1:] = arguments
    try:
        main()
    except SystemExit as ended:
        assert not ended.code, (arguments, ended.code)
    print(end="\\0", flush=True)
"""


def frictionbench(environment: Path, *commands: list[str]) -> list[str]:
    """What commands print, one after the other in one Python; nothing is compiled, which would take a minute."""
    done = python(environment, COMMANDS, json.dumps(commands), NUMBA_DISABLE_JIT="1")
    assert done.returncode == 0, done.stderr
    return done.stdout.split("\0")[:-1]


def test_install_works_without_home(installed) -> None:
    baseline = next(installed.glob("lib/python*/site-packages/frictionbench/results/baselines/smoke.tsv"))
    assert "lemke\tsolve\t" in baseline.read_text(encoding="utf-8")
    results, mine = installed.parent / "results of mine", installed.parent / "baselines" / "mine.tsv"
    commands = (
        (["--help"], "Compare solvers for the friction LCPs"),
        (["list", "solvers"], "nsgs"),
        (["run", "smoke", "--scene", "stack", "--solver", "lemke", "--jobs", "1", "--out", str(results)], "results of mine"),
        (["compare", str(mine), str(results), "--accept"], "accepted: "),
        (["compare", str(mine), str(results)], "## worse 0"),
        (["report", str(results)], "report: "),
        (["solve", "stack", "--solver", "lemke"], "fastest on this problem: lemke"),
    )
    printed = frictionbench(installed, *(arguments for arguments, _ in commands))
    for (arguments, told), text in zip(commands, printed, strict=True):
        assert told in text, arguments
    assert next(results.glob("*.html")).stat().st_size > 5 * 10**4
