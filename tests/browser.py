"""Pages as a browser sees them: Debian's chromium, headless; axe-core from the test extra."""

import html
import json
import os
import re
import shutil
import subprocess
from importlib.metadata import files

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-extensions",
    "--disable-default-apps",
    "--host-resolver-rules=MAP * ~NOTFOUND",
    "--virtual-time-budget=20000", "--enable-logging=stderr", "--v=0",
)  # fmt: skip

needs_chromium = pytest.mark.skipif(
    CHROMIUM is None, reason="chromium is not installed: apt install chromium"
)


def open_page(page, profile, *flags):
    """The document of a file or address after loading, and what the browser says of its console."""
    address = page if isinstance(page, str) else page.as_uri()
    command = [CHROMIUM, *FLAGS, f"--user-data-dir={profile}", *flags, "--dump-dom", address]
    environment = {**os.environ, "HOME": str(profile)}
    result = subprocess.run(command, capture_output=True, text=True, timeout=100, env=environment)
    assert result.returncode == 0, result.stderr[-2000:]
    console = [line for line in result.stderr.splitlines() if "CONSOLE" in line]
    return result.stdout, console


def requests_of_the_page(log):
    """URLs that the page itself asked for; what the browser asks for by itself has no origin."""
    parameters = [event.get("params", {}) for event in json.loads(log)["events"]]
    asked = [
        params["url"] for params in parameters if params.get("initiator", "not an origin") != "not an origin"
    ]
    return [url for url in asked if not url.startswith(("file:", "data:"))]


def axe_source():
    (script,) = [file for file in files("axe-core-python") or [] if file.name == "axe.min.js"]
    return script.read_text(encoding="utf-8")


def serious_faults(page, folder, scheme="light"):
    """What axe-core finds in a page, in colors for day or night: impact, rule, and where."""
    run = (
        "setTimeout(() => axe.run().then(found => { const made = document.createElement('pre');"
        " made.id = 'axe-found'; made.textContent = JSON.stringify(found.violations.map("
        "v => [v.impact, v.id, v.nodes.map(n => n.target.join(' '))]));"
        " document.body.append(made); }), 2000);"
    )
    probed = page.with_name(f"probed-{scheme}-{page.name}")
    text = page.read_text(encoding="utf-8")
    probed.write_text(
        text.replace("</body>", f"<script>{axe_source()}</script><script>{run}</script></body>"),
        encoding="utf-8",
    )
    colors = ["--blink-settings=preferredColorScheme=0"] if scheme == "dark" else []
    dom, _ = open_page(probed, folder / "profile", *colors)
    probed.unlink()
    found = json.loads(html.unescape(re.search(r'<pre id="axe-found">(.*?)</pre>', dom)[1]))
    return [violation for violation in found if violation[0] in ("serious", "critical")]
