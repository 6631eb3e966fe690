"""report.md shows names of others as text: no tags, links, tables or control characters of theirs."""

from frictionbench.reports.markdown import write_markdown
from frictionbench.reports.run import read_run
from tests.helpers.made_results import MACHINE, SETTINGS, solve_row, unanswered_row, write_folder

EVIL = "<img src=x onerror=alert(1)>|`](javascript:x)\n# h\x1b[31m"


def test_names_of_others(tmp_path) -> None:
    rows = [solve_row(name, f"{problem}", scene=f"s{EVIL}") for name in (EVIL, "b") for problem in range(12)]
    rows.append(unanswered_row(f"{EVIL}c", "0", "skipped", reason=f"{EVIL} is not installed"))
    rows.append(solve_row("d", "0", verdict="wrong"))
    facts = {"settings": SETTINGS | {"suite": EVIL}, "machine": MACHINE | {"processor": EVIL, "cores": EVIL}, "finished": EVIL}
    folder = write_folder(tmp_path / "run", rows, **facts)
    (tmp_path / "mine").write_text("mine", encoding="utf-8")
    (folder / "report.md").symlink_to(tmp_path / "mine")
    told = write_markdown(folder, read_run(folder)).read_text(encoding="utf-8")
    assert "alert(1)" in told
    assert [text for text in ("<", "\x1b", "\n# h") if text in told] == []
    assert (tmp_path / "mine").read_text(encoding="utf-8") == "mine"
