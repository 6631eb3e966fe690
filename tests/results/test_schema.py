"""The documentation page of the columns is generated from the schema."""

from frictionbench.results.schema import TABLES, VERSION, describe
from tests.helpers.paths import ROOT


def test_page_of_columns_is_generated() -> None:
    written = (ROOT / "docs" / "columns.md").read_text(encoding="utf-8")
    assert written == describe(), "python -m frictionbench.results.schema > docs/columns.md"


def test_page_of_columns_is_complete() -> None:
    page = describe()
    assert f"Schema version {VERSION};" in page
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith("| `")]
    assert [row[0].strip("| `") for row in rows] == [column.name for columns in TABLES.values() for column in columns]
    assert {len(row) for row in rows} == {4}
