"""The documentation page of the columns is generated from the schema."""

from tests.helpers.paths import ROOT
from tools.columns import describe


def test_page_of_columns_is_generated() -> None:
    written = (ROOT / "docs" / "columns.md").read_text(encoding="utf-8")
    assert written == describe(), "python -m tools.columns > docs/columns.md"
