"""The directive `command-line`: a section for each command with its help, as the program prints it."""

import os
from typing import Any
from unittest.mock import patch

from docutils import nodes
from sphinx.util.docutils import SphinxDirective
from typer.testing import CliRunner

from frictionbench.commands.cli import app as program


def commands() -> list[str]:
    """The names of all commands, in the order of the source."""
    return [str(info.name or info.callback.__name__.rstrip("_")).replace("_", "-") for info in program.registered_commands]


def help_of(command: str) -> str:
    """What `frictionbench COMMAND --help` prints."""
    with patch.dict(os.environ, COLUMNS="100", TERMINAL_WIDTH="100"):
        return CliRunner().invoke(program, [command, "--help"], prog_name="frictionbench").output.strip()


class CommandLine(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        return [self.section(name) for name in commands()]

    def section(self, name: str) -> nodes.section:
        found = nodes.section(ids=[f"frictionbench-{name}"], names=[f"frictionbench {name}"])
        found.extend([nodes.title(text=name), nodes.literal_block(text=help_of(name), language="text")])
        return found


def setup(app: Any) -> dict[str, bool]:
    app.add_directive("command-line", CommandLine)
    return {"parallel_read_safe": True}
