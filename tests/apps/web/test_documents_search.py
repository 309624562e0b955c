"""The search of the documents that `make docs` builds, opened from a disk."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import BrowserContext
from recordings import ROOT

SCRIPT = "javascripts/iframe-worker.js"

WORKER = """
addEventListener("message", async (event) => {
  await importScripts("double.js");
  postMessage(self.double(event.data));
});
"""

ASKED = """async () => {
  const worker = new Worker(new URL("worker.js", location));
  const got = new Promise((resolve) => worker.addEventListener("message", resolve));
  worker.postMessage(21);
  return (await got).data;
}"""


def test_the_script_of_a_worker_runs_in_a_page_that_is_opened_from_a_disk(
    context: BrowserContext, tmp_path: Path
) -> None:
    (tmp_path / "worker.js").write_text(WORKER)
    (tmp_path / "double.js").write_text("self.double = (number) => 2 * number;")
    (tmp_path / "shim.js").write_text((ROOT / "docs" / SCRIPT).read_text())
    (tmp_path / "page.html").write_text("<script src='shim.js'></script><body>")
    page = context.new_page()
    page.goto((tmp_path / "page.html").as_uri())
    assert page.evaluate(ASKED) == 42


def test_the_documents_load_it_and_the_index_without_anything_from_elsewhere() -> None:
    settings = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert f"\n  polyfills: [{SCRIPT}]\n" in settings
    assert "\n  - offline #" in settings
    assert "\nuse_directory_urls: false" in settings
    assert "\n  font: false" in settings
