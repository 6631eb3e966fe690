"""What a run stores: tables with their schema, files beside them, and the comparison of two runs.

The names below are what programs outside the package use; each is imported when it is first used, because pandas and pyarrow
take half a second.
"""

from typing import TYPE_CHECKING

from frictionbench.lazy import importer

if TYPE_CHECKING:
    from frictionbench.problems.verdicts import measured as measured
    from frictionbench.results.conventions import (
        COLD as COLD,
        SHUFFLED as SHUFFLED,
        WARM as WARM,
        RankBy as RankBy,
        count as count,
        scene_title as scene_title,
    )
    from frictionbench.results.files import (
        ResultsError as ResultsError,
        read_json as read_json,
        subfolder as subfolder,
        write_text as write_text,
    )
    from frictionbench.results.schema import SCHEMA_VERSION as SCHEMA_VERSION, TABLES as TABLES
    from frictionbench.results.store import read_table as read_table, rows as rows

__getattr__ = importer(__name__, __file__)
