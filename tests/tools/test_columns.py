"""The documentation page of the columns is generated from the schema."""

from frictionbench.results import SCHEMA_VERSION, TABLES
from tests.helpers.paths import ROOT
from tools.columns import describe


def test_page_of_columns_is_generated() -> None:
    written = (ROOT / "docs" / "columns.md").read_text(encoding="utf-8")
    assert written == describe(), "python -m tools.columns > docs/columns.md"


def test_page_of_columns_is_complete() -> None:
    page = describe()
    assert f"Schema version {SCHEMA_VERSION};" in page
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith("| `")]
    assert [row[0].strip("| `") for row in rows] == [column.name for columns in TABLES.values() for column in columns]
    assert {len(row) for row in rows} == {4}
