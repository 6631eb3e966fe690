"""Studies at reduced size: their tables computed in the test process, and their accounts told and drawn."""

import json
from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from frictionbench.harness.cells.worker import plain
from frictionbench.harness.studies import STUDIES
from frictionbench.reports.studies import ACCOUNTS, Account
from frictionbench.results.studies import StudyTables


def reduced(name: str, runs: Mapping[str, pd.DataFrame] | None = None, **arguments: Mapping[str, Any]) -> StudyTables:
    """The tables of a study, computed with these arguments by table, and as they are read from a file."""
    study, tables = STUDIES[name], dict(runs or {})
    for table in study.tables:
        rows = [plain(row) for row in table.rows(**arguments.get(table.name, {}))]
        assert all(list(row) == list(table.columns) for row in rows), table.name
        tables[table.name] = pd.DataFrame(json.loads(json.dumps(rows)), columns=list(table.columns))
    return StudyTables(study.description, tables)


def told(tables: StudyTables) -> Account:
    """The account, of which every panel can be drawn and every sentence is whole."""
    account = ACCOUNTS[tables.about.name](tables)
    for text in (account.answer, account.result, account.limits, *(figure.caption for figure in account.figures)):
        assert text.endswith("."), text
        assert "nan" not in text.split(), text
    for figure in account.figures:
        for panel in figure.panels:
            panel.draw(Figure().subplots())
    return account
