# SPDX-License-Identifier: MIT
"""The report pages in a browser: drawn, without a console message and without the network."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

BROWSER = shutil.which("chromium") or shutil.which("google-chrome") or shutil.which("chrome")
pytestmark = pytest.mark.skipif(BROWSER is None, reason="no Chromium")

# Counts the pixels of the view in space, and those that differ after it was turned.
# The view is drawn when the browser has laid out the page, which it may do late.
PROBE = """<script>function probe(left) {
  const canvas = document.querySelector("#space canvas");
  const pixels = () => {
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const ink = copy.getContext("2d", { willReadFrequently: true });
    ink.drawImage(canvas, 0, 0);
    return ink.getImageData(0, 0, copy.width, copy.height).data;
  };
  const before = pixels();
  if (left > 0 && before.every(value => value === 0)) {
    requestAnimationFrame(() => {});  // asks for a picture
    return void setTimeout(probe, 100, left - 1);
  }
  canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
  const after = pixels();
  let drawn = 0, turned = 0;
  for (let i = 3; i < before.length; i += 4) {
    drawn += before[i] > 0;
    turned += before[i] !== after[i];
  }
  const plot = document.querySelector("figure[data-kind=time] svg");
  const box = plot.getBoundingClientRect();
  plot.dispatchEvent(new PointerEvent("pointermove",
    { clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 }));
  const tip = document.getElementById("tip").textContent;
  document.body.dataset.probe = JSON.stringify({ drawn, turned, tip });
}
setTimeout(probe, 300, 80);</script>"""


def edvo(*arguments: str) -> None:
    subprocess.run([sys.executable, "-m", "edvo", *arguments], capture_output=True, check=True)


@pytest.fixture(scope="module")
def pages(sequence: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("pages")
    runs = [str(folder / name) for name in ("one", "two")]
    for run in runs:
        edvo("run", str(sequence), "--max-frames", "40", "-o", run, "--quiet")
    edvo("report", *runs, "-o", str(folder / "comparison.html"))
    return {"report": folder / "one" / "report.html", "comparison": folder / "comparison.html"}


@pytest.mark.parametrize("name", ["report", "comparison"])
def test_the_page_draws_says_nothing_and_asks_for_nothing(
    pages: dict[str, Path], name: str, tmp_path: Path
) -> None:
    page = tmp_path / "page.html"
    text = pages[name].read_text(encoding="utf-8")
    page.write_text(text.replace("</body>", PROBE + "</body>"), encoding="utf-8")
    log = tmp_path / "net.json"
    command = [
        str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run",
        "--disable-background-networking", f"--user-data-dir={tmp_path / 'profile'}",
        "--window-size=1300,2000", "--enable-logging=stderr", f"--log-net-log={log}",
        "--host-resolver-rules=MAP * ~NOTFOUND", "--virtual-time-budget=10000", "--dump-dom",
        page.as_uri(),
    ]  # fmt: skip
    result = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    assert "CONSOLE" not in result.stderr, result.stderr
    probe = re.search(r'data-probe="([^"]*)"', result.stdout)
    assert probe, result.stdout[-2000:]
    seen = json.loads(probe.group(1).replace("&quot;", '"'))
    assert seen["drawn"] > 1000 and seen["turned"] > 500
    assert " s" in seen["tip"] and ("live" in seen["tip"] or "one" in seen["tip"])
    # What the browser itself asks for has no page as its initiator.
    asked = re.findall(r'"initiator":"(?!not an origin)[^"]*"[^{}]*"url":"(https?:[^"]*)"', log.read_text())
    assert not asked
