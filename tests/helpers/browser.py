"""Run headless Chromium, if it is installed, and look there at a page as its readers do."""

import html
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.helpers.paths import HELPERS

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FRAMES = ("seen", 400), ("seen", 1300), ("printed", 703)  # px; A4 without its margins
SHEET = '<link rel="stylesheet"[^>]* href="([^"?]+)[^>]*>'
HEAR = """addEventListener("message", ({ data }) => {
  document.body.append(Object.assign(document.createElement("pre"), { textContent: data }));
});"""


def in_browser(test):
    """Mark a test that runs where Chromium is installed, among the slow ones."""
    return pytest.mark.slow(pytest.mark.skipif(BROWSER is None, reason="needs the browser Chromium")(test))


def browse(page: Path, *wanted: str, anchor: str = "") -> str:
    """Open a page in headless Chromium and return its standard output."""
    quiet = ("--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--hide-scrollbars")
    quiet += ("--disable-component-update", "--disable-sync", f"--user-data-dir={page.parent / 'profile'}")
    command = [str(BROWSER), "--headless", "--no-sandbox", *quiet, "--virtual-time-budget=3000", *wanted]
    done = subprocess.run([*command, f"{page.as_uri()}#{anchor}"], capture_output=True, text=True, check=True, timeout=300)
    return done.stdout


def audited(page: Path, accessible: bool = True) -> list[dict]:
    """What page_audit.js finds on a page in each of the FRAMES, light and dark; and axe-core, unless told otherwise."""
    axe = Path(pytest.importorskip("axe_core_python").__file__).with_name("axe.min.js").read_text(encoding="utf-8")
    audit = (HELPERS / "page_audit.js").read_text(encoding="utf-8")
    text = re.sub('<meta http-equiv="Content-Security-Policy"[^>]*>', "", page.read_text(encoding="utf-8"))
    seen = text.replace("</body>", f"<script>{axe if accessible else ''}</script><script>{audit}</script></body>")
    page.with_name("seen.html").write_text(seen, encoding="utf-8")
    styled = re.sub(SHEET, lambda link: f"<style>{(page.parent / link[1]).read_text(encoding='utf-8')}</style>", seen)
    page.with_name("printed.html").write_text(styled.replace("@media print", "@media all"), encoding="utf-8")
    frames = [f'<iframe src="{name}.html" width="{width}" height="900" style="border: 0"></iframe>' for name, width in FRAMES]
    around = page.with_name("around.html")
    around.write_text(f"<body><script>{HEAR}</script>{''.join(frames)}", encoding="utf-8")
    opened = [browse(around, "--dump-dom", *dark) for dark in ([], ["--blink-settings=preferredColorScheme=0"])]
    views = [json.loads(html.unescape(told)) for told in re.findall("<pre>(.*?)</pre>", "".join(opened), re.DOTALL)]
    assert len(views) == 2 * len(FRAMES)
    return views


def faults(page: Path, accessible: bool = True) -> list[str]:
    """What any of the views of a page has to be mended for."""
    return [f"{view['width']} px: {fault}" for view in audited(page, accessible) for fault in view["faults"]]
