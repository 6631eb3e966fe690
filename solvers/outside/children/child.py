"""A child process that keeps a library ready: started by the first question, one for all that follow.

It is on its parent's core, under its parent's bound on memory, and ends with it, by the kernel's hand; a child that dies takes
only the question with it, and the next one is answered by another.
"""

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from frictionbench.solvers.outside.children import talk

_FOLDER = Path(__file__).parent


class DiedError(RuntimeError):
    """The child ended instead of answering."""


class Child:
    """A script of this folder, or any by its absolute path, in a process of the given Python.

    held: what the child was told last by `tell`; it forgets that when it dies.
    """

    def __init__(self, script: str, python: str) -> None:
        self._command = [python, str(_FOLDER / script), str(os.getpid())]
        self._process: subprocess.Popen[bytes] | None = None
        self.held: object = None

    def tell(self, what: object, **message: Any) -> None:
        """Let the child hold a message on `what`, unless it holds it already."""
        if self.pid is not None and self.held is what:
            return
        self.ask(**message)
        self.held = what

    def ask(self, **message: Any) -> dict[str, Any]:
        """The answer to a message. Errors: DiedError, with the signal or exit code."""
        if self.pid is None:
            self.end()
            talked = os.environ | {"PYTHONPATH": str(_FOLDER)}  # a script says `from talk import serve`
            self._process = subprocess.Popen(self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=talked)
        process = self._process
        assert process is not None
        assert process.stdin is not None
        assert process.stdout is not None
        answer = None
        try:
            talk.send(process.stdin, message)
            answer = talk.receive(process.stdout)
        except BrokenPipeError:
            pass
        except BaseException:  # broken off in the middle: what it may still say answers nothing
            self.end()
            raise
        if answer is None:
            code = process.wait()
            self.end()
            how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
            raise DiedError(f"the library's process died: {how}")
        return answer

    def end(self) -> None:
        """Kill the child, if there is one."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            for pipe in (self._process.stdin, self._process.stdout):
                with suppress(BrokenPipeError):
                    pipe.close()  # type: ignore[union-attr]
        self._process, self.held = None, None

    @property
    def pid(self) -> int | None:
        """Its process, while it lives."""
        return self._process.pid if self._process is not None and self._process.poll() is None else None


_children: dict[tuple[str, str], Child] = {}


def child(script: str, python: str = sys.executable) -> Child:
    """The child of this process that runs a script."""
    return _children.setdefault((script, python), Child(script, python))


def living() -> list[int]:
    """The processes of this process's children."""
    return [made.pid for made in _children.values() if made.pid is not None]
