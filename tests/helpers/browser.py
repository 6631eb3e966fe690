"""Run headless Chromium, if it is installed."""

import shutil
import subprocess
from pathlib import Path

import pytest

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


def in_browser(test):
    """Mark a test that runs where Chromium is installed, among the slow ones."""
    return pytest.mark.slow(pytest.mark.skipif(BROWSER is None, reason="needs the browser Chromium")(test))


def browse(page: Path, *wanted: str, anchor: str = "") -> str:
    """Open a page in headless Chromium and return its standard output."""
    quiet = ("--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--hide-scrollbars")
    quiet += ("--disable-component-update", "--disable-sync", f"--user-data-dir={page.parent / 'profile'}")
    command = [str(BROWSER), "--headless", "--no-sandbox", *quiet, "--virtual-time-budget=3000", *wanted]
    done = subprocess.run([*command, f"{page.as_uri()}#{anchor}"], capture_output=True, text=True, check=True, timeout=120)
    return done.stdout
