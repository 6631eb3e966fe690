"""The check of the built site finds links that lead nowhere and what is loaded from elsewhere; links of pages stay on it."""

import importlib
from types import ModuleType

import pytest

from tests.helpers.paths import ROOT


@pytest.fixture
def extension(monkeypatch):
    """A module of docs/_ext by its name."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))

    def found(name: str) -> ModuleType:
        pytest.importorskip("sphinx")
        return importlib.import_module(name)

    return found


def test_faults_of_a_site(extension, tmp_path) -> None:
    (tmp_path / "a.html").write_text(
        '<p id="here"><a href="b.html#there">1</a><a href="#here">2</a><a href="c.html">3</a><a href="b.html#gone">4</a>'
        '<a href="https://example.com">5</a><script src="https://cdn.example.com/x.js"></script>'
        '<link rel="stylesheet" href="b.html">',
        encoding="utf-8",
    )
    (tmp_path / "b.html").write_text('<p id="there">', encoding="utf-8")
    (tmp_path / "s.css").write_text("@font-face { src: url(https://fonts.example.com/f.woff) }", encoding="utf-8")
    assert extension("check_site").faults(tmp_path) == [
        "a.html: loads https://cdn.example.com/x.js",
        "a.html: c.html does not exist",
        "a.html: b.html#gone has no such place",
        "s.css: a style fetches from elsewhere",
    ]


def test_links_that_leave_docs(extension) -> None:
    source = ["[how](../CONTRIBUTING.md#a-release), [code](../tools/direct), [page](ci.md)"]
    extension("links").replace_links(None, "peers", source)
    assert source == ["[how](contribute.md#a-release), code, [page](ci.md)"]
