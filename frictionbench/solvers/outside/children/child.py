"""A child process that has a library loaded: started by the first request and used for all that follow.

It runs on its parent's core and under its memory limit, and the kernel kills it when the parent ends. If the child dies, only
the current request fails; the next one starts another child.
"""

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from frictionbench.solvers.outside.children import messages

_FOLDER = Path(__file__).parent


class DiedError(RuntimeError):
    """The child ended without a reply."""


class Child:
    """A script of this folder, or any script by its absolute path, in a process of the given Python."""

    def __init__(self, script: str, python: str) -> None:
        self._command = [python, str(_FOLDER / script), str(os.getpid())]
        self._process: subprocess.Popen[bytes] | None = None

    def ask(self, **message: Any) -> dict[str, Any]:
        """The reply to a message. Errors: DiedError, with the signal or exit code."""
        if self.pid is None:
            self.end()
            environment = os.environ | {"PYTHONPATH": str(_FOLDER)}  # scripts import messages
            self._process = subprocess.Popen(self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment)
        process = self._process
        assert process is not None
        assert process.stdin is not None
        assert process.stdout is not None
        answer = None
        try:
            messages.send(process.stdin, message)
            answer = messages.receive(process.stdout)
        except BrokenPipeError:
            pass
        except BaseException:  # interrupted: a late reply would be taken for the next one's
            self.end()
            raise
        if answer is None:
            code = process.wait()
            self.end()
            how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
            raise DiedError(f"the library's process died: {how}")
        return answer

    def end(self) -> None:
        """Kill the child if it is running."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            for pipe in (self._process.stdin, self._process.stdout):
                with suppress(BrokenPipeError):
                    pipe.close()  # type: ignore[union-attr]
        self._process = None

    @property
    def pid(self) -> int | None:
        """Its process id while it is running, or None."""
        return self._process.pid if self._process is not None and self._process.poll() is None else None


_children: dict[tuple[str, str], Child] = {}


def child(script: str, python: str = sys.executable) -> Child:
    """This process's child that runs a script; started by its first request."""
    return _children.setdefault((script, python), Child(script, python))


def living() -> list[int]:
    """The process ids of this process's running children."""
    return [made.pid for made in _children.values() if made.pid is not None]
