"""Run the command line inside the test process, which saves the import time and the start of a worker server."""

import os
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from unittest.mock import patch

from frictionbench.commands import cli


@dataclass(frozen=True)
class Done:
    returncode: int
    stdout: str
    stderr: str


def frictionbench(*arguments: str, cwd: Path | None = None) -> Done:
    """Run a command in a folder with 200 columns and return its exit code and output, which is not that of an error of ours."""
    out, err, code = StringIO(), StringIO(), 0
    with (
        chdir(cwd or os.curdir),
        redirect_stdout(out),
        redirect_stderr(err),
        patch.object(sys, "argv", ["frictionbench", *arguments]),
        patch.object(cli, "_SIGNALS", ()),
        patch.dict(os.environ, COLUMNS="200"),
    ):
        try:
            cli.main()
        except SystemExit as ended:
            code = int(ended.code or 0)
    assert code != 3, err.getvalue()
    return Done(code, out.getvalue(), err.getvalue())
