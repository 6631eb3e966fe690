"""The documentation site: Sphinx with MyST and furo. Nothing on it is loaded from elsewhere, so that it can be read offline."""

import sys
from importlib.metadata import version as installed
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent / "_ext"), str(Path(__file__).parents[1])]

project = "frictionbench"
author = "The frictionbench developers"
version = release = installed("frictionbench")
extensions = ["myst_parser", "sphinx.ext.autodoc", "links", "command_line", "public_face", "published_results", "cells"]
extensions += ["unbroken"]
exclude_patterns = ["_build", "paper"]
EXTRA = Path(__file__).parent / "_build" / "extra"  # the pages of published results, which are made before a build
EXTRA.mkdir(parents=True, exist_ok=True)
html_extra_path = [str(EXTRA)]
html_theme = "furo"
html_title = f"frictionbench {version}"
html_copy_source = False
smartquotes = False  # it would make a dash of the -- of options
html_show_sphinx = False
html_show_copyright = False
html_static_path = ["_static"]
templates_path = ["_templates"]
html_css_files = ["wrap.css"]
highlight_language = "text"
myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence"]
suppress_warnings = ["toc.empty_glob"]  # pages that are matched by a pattern come and go
