"""Find a browser for the tests of the page, or install one.

`python -m tests.tools.browser` prints the path of a Chromium. Debian's package is taken where we
are root and apt-get is there, playwright's own download elsewhere.
"""

import os
import shutil
import subprocess
import sys

NAMES = ("chromium", "chromium-browser", "google-chrome")


def find_browser() -> str | None:
    """Path of an installed Chromium: the system's, else playwright's own."""
    for name in NAMES:
        if path := shutil.which(name):
            return path
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        path = playwright.chromium.executable_path
    return path if os.path.exists(path) else None


def install_browser() -> None:
    """Install a Chromium with the means of this machine."""
    if os.geteuid() == 0 and shutil.which("apt-get"):
        subprocess.run(["apt-get", "update", "-qq"], check=True)
        subprocess.run(["apt-get", "install", "-y", "-qq", "chromium"], check=True)
        return
    subprocess.run([sys.executable, "-m", "playwright", "install", "chromium"], check=True)


def main() -> int:
    """Print the browser's path; status 1 if there is none and none can be installed."""
    if find_browser() is None:
        try:
            install_browser()
        except (OSError, subprocess.CalledProcessError) as error:
            print(f"no browser could be installed: {error}", file=sys.stderr)
    path = find_browser()
    print(path or "no Chromium found: install the package `chromium`")
    return 0 if path else 1


if __name__ == "__main__":
    sys.exit(main())
