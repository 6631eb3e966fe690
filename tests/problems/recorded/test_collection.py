"""Recorded problems fetched from a local server: checksums, cache, resumed downloads, use without a network."""

import gzip
import hashlib
import os
import threading
import tracemalloc
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from frictionbench.harness.plans.choose import RunOptions, choose
from frictionbench.problems import InputError
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.recorded import collection, fclib, read

FAMILY = "Local/siconos/Chain"


class Server:
    """Serves `files` by path, with `headers` and a code, and records the requested paths."""

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}
        self.headers: dict[str, str] = {}
        self.code = 200
        self.asked: list[str] = []
        server = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:  # the library's name
                server.asked.append(self.path.lstrip("/"))
                content = server.files.get(self.path.lstrip("/"))
                self.send_response(404 if content is None else server.code)
                for name, value in server.headers.items():
                    self.send_header(name, value)
                self.end_headers()
                self.wfile.write(content or b"")

            def log_message(self, *_) -> None:
                pass

        self._http = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.address = f"http://127.0.0.1:{self._http.server_port}"
        threading.Thread(target=self._http.serve_forever, daemon=True).start()

    def stop(self) -> None:
        self._http.shutdown()
        self._http.server_close()


@pytest.fixture
def server(tmp_path, monkeypatch):
    """A server with a family of three files, a registry of them, and an empty cache."""
    served = Server()
    rows = ["path,bytes,sha256"]
    for seed in range(3):
        fclib.write(random_problem(seed, contacts=3), tmp_path / "made.hdf5")
        content, path = (tmp_path / "made.hdf5").read_bytes(), f"{FAMILY}/chain-{seed}.hdf5"
        served.files[path] = content
        rows.append(f"{path},{len(content)},{hashlib.sha256(content).hexdigest()}")
    (tmp_path / "registry.csv").write_text("\n".join(rows) + "\n", encoding="ascii")
    monkeypatch.setattr(collection, "REGISTRY", tmp_path / "registry.csv")
    monkeypatch.setenv("FRICTIONBENCH_FCLIB", served.address)
    monkeypatch.setenv("FRICTIONBENCH_CACHE", str(tmp_path / "cache"))
    collection.registry.cache_clear()
    yield served
    collection.registry.cache_clear()
    served.stop()


def test_fetch_is_cached(server) -> None:
    assert len(list(collection.fetch(FAMILY))) == 3
    assert read(collection.cache_folder() / FAMILY / "chain-0.hdf5").hash == random_problem(0, contacts=3).hash
    server.stop()
    assert len(list(collection.fetch(FAMILY))) == 3
    assert len(server.asked) == 3
    plan = choose(RunOptions("recorded", data=["fclib/Chain"]))
    assert [Path(source.file).name for source in plan.sources] == [f"chain-{k}.hdf5" for k in range(3)]


def test_interrupted_download_resumes(server) -> None:
    missing = f"{FAMILY}/chain-1.hdf5"
    content = server.files.pop(missing)
    with pytest.raises(InputError, match=rf"^{missing}: 404"):
        list(collection.fetch(FAMILY))
    server.files[missing] = content
    server.asked.clear()
    assert len(list(collection.fetch(FAMILY))) == 3
    assert server.asked == [missing, f"{FAMILY}/chain-2.hdf5"]


@pytest.mark.parametrize(
    ("spoil", "complaint"),
    [
        (lambda good: good[:-1] + bytes([good[-1] ^ 1]), "hash"),
        (lambda good: good[: len(good) // 2], "of"),
        (lambda good: good + b"x" * 10**6, "longer than the"),
        (lambda _: b"", "0 bytes of"),
    ],
    ids=["changed", "cut", "longer", "empty"],
)
def test_checksum_mismatch_is_refused(server, spoil, complaint) -> None:
    path = f"{FAMILY}/chain-0.hdf5"
    server.files[path] = spoil(server.files[path])
    with pytest.raises(InputError, match=rf"^{path}: .*{complaint}"):
        list(collection.fetch(FAMILY))
    assert not (collection.cache_folder() / path).exists()


def test_redirects(server) -> None:
    """They are followed, since only the sum counts; one that never ends is refused, and so is one to a file of this machine."""
    for target in (f"{server.address}/{FAMILY}/chain-0.hdf5", "file:///etc/hostname"):
        server.code, server.headers = 302, {"Location": target}
        with pytest.raises(InputError, match=rf"^{FAMILY}/chain-0\.hdf5: "):
            list(collection.fetch(FAMILY))


def test_answer_that_unpacks_to_much(server) -> None:
    path = f"{FAMILY}/chain-0.hdf5"
    server.files[path], server.headers = gzip.compress(bytes(10**8)), {"Content-Encoding": "gzip"}
    tracemalloc.start()
    with pytest.raises(InputError, match="longer than the"):
        list(collection.fetch(FAMILY))
    assert tracemalloc.get_traced_memory()[1] < 2**26
    tracemalloc.stop()
    assert not [*collection.cache_folder().rglob("*.hdf5")]


@pytest.mark.parametrize("kind", ["pipe", "link"])
def test_what_is_no_file_in_the_cache_is_refused(server, tmp_path, kind) -> None:
    path = collection.cache_folder() / FAMILY / "chain-0.hdf5"
    path.parent.mkdir(parents=True)
    os.mkfifo(path) if kind == "pipe" else path.symlink_to(tmp_path / "victim")
    with pytest.raises(InputError, match={"pipe": "is no regular file", "link": "is a link"}[kind]):
        list(collection.fetch(FAMILY))
    assert not (tmp_path / "victim").exists()


def test_family_names() -> None:
    assert collection.family("fclib/Capsules") == "Local/siconos/Capsules"
    assert collection.family("fclib/global/siconos/capsules") == "Global/siconos/Capsules"
    with pytest.raises(InputError, match=r"^family: unknown family 'fclib/Nonesuch'; known are fclib/Global"):
        collection.family("fclib/Nonesuch")
    for entries in collection.registry().values():
        assert all(len(entry.sha256) == 64 and entry.size > 0 and ".." not in entry.path for entry in entries)


def test_unusable_data(server, tmp_path) -> None:
    """Missing data, and two files that would be one problem, of which one would not be run."""
    pair = [tmp_path / version / "steps" for version in ("old", "new")]
    for folder in pair:
        folder.mkdir(parents=True)
        (folder / "p.npz").touch()
    assert len(choose(RunOptions("recorded", data=[str(pair[0]), str(pair[0])])).sources) == 1
    for suite, data, complaint in (
        ("recorded", [*map(str, pair)], r"^data: .*old/steps/p.npz and .*new/steps/p.npz would be one problem"),
        ("recorded", [], r"^data: recorded needs --data DIR"),
        ("recorded", [str(tmp_path / "nothing")], r"^data: no problems in .*nothing"),
        ("recorded", ["fclib/Chain"], r"^data: no problems in fclib/Chain; fetch it"),
    ):
        with pytest.raises(InputError, match=complaint):
            choose(RunOptions(suite, data=data))
