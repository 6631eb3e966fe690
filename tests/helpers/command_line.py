"""The command line within this process, which has paid for its imports and has a server of workers already."""

import os
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from unittest.mock import patch

from frictionbench.harness import cli


@dataclass(frozen=True)
class Done:
    returncode: int
    stdout: str
    stderr: str


def frictionbench(*arguments: str, cwd: Path | None = None) -> Done:
    """What a command prints and ends with, from a folder, on a wide screen. Errors: whatever would be a traceback."""
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
    return Done(code, out.getvalue(), err.getvalue())
