"""`live docs`: pages are found by name, by path, by nearly right names and by search, and served on this machine."""

import re
import threading
import urllib.request
from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.cli import docs
from tests.cli.command import run_live
from tests.places import ROOT
from tools.reference.reference_pages import reference_pages


@pytest.fixture
def site(tmp_path, monkeypatch):
    """A small site, in place of the built one."""
    for path in (
        "index.html", "search.html", "_static/theme.html", "how-to/hall/audience.html", "reference/osc/index.html",
        "reference/osc/audience.html", "reference/patch/osc.html", "tutorials/visual-artist.html",
    ):  # fmt: skip
        file = tmp_path / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"<title>{path}</title>")
    monkeypatch.setattr(docs, "SITE", tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("wanted", "found"),
    [
        ("", "index.html"),
        ("osc", "reference/osc/index.html"),
        ("audience", "how-to/hall/audience.html"),
        ("reference/osc/audience", "reference/osc/audience.html"),
        ("patch/osc", "reference/patch/osc.html"),
        ("Visual artist", "tutorials/visual-artist.html"),
        ("osc.md", "reference/osc/index.html"),
        ("/dance/light/key", "search.html?q=%2Fdance%2Flight%2Fkey"),
        ("hands that are held", "search.html?q=hands+that+are+held"),
    ],
)
def test_pages_are_found_by_name_path_or_search(site, wanted, found):
    assert docs.find_page(site, wanted) == found


def test_a_nearly_right_name_is_searched_for_or_told(site):
    assert docs.find_page(site, "audiense") == "search.html?q=audiense"
    done = run_live("docs", "audiense", "--where")
    assert (done.returncode, done.stdout) == (2, "")
    assert "did you mean audience?" in done.stderr


def test_a_site_that_is_not_built_names_the_remedy(tmp_path):
    with pytest.raises(PersonError) as error:
        docs.find_page(tmp_path, "osc")
    assert error.value.remedy == "make docs"


def test_the_command_tells_where_a_page_is(site):
    assert run_live("docs", "osc", "--where").stdout.strip() == str(site / "reference/osc/index.html")


def test_pages_are_served_on_this_machine_only(site):
    with docs.open_server(site) as server:
        host, port = server.server_address[:2]
        assert host == "127.0.0.1"
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/reference/osc/", timeout=30) as answer:
                assert answer.read() == b"<title>reference/osc/index.html</title>"
        finally:
            server.shutdown()
            thread.join()


def test_every_page_that_messages_name_exists():
    """`live docs NAME` in messages, helps and comments of patches names a page of docs/, or one that is made."""
    pages = {path.relative_to(ROOT / "docs") for path in (ROOT / "docs").rglob("*.md")}
    pages |= {Path("reference", path) for path in reference_pages()}
    names = {page.parent.name if page.name == "index.md" else page.stem for page in pages}
    for folder, ending in (("live", "*.py"), ("patches", "*.toml"), ("docs", "*.md")):
        for file in (ROOT / folder).rglob(ending):
            for name in re.findall(r"`live docs ([\w-]+)`", file.read_text(encoding="utf-8")):
                assert name in names or name == "NAME", f"{file}: {name}"


def test_a_browser_that_waits_for_the_page_gets_it(site, tmp_path, monkeypatch):
    """As browsers of a terminal do: the program that opens the page returns when it has been read."""
    read = []

    def browse(address):
        with urllib.request.urlopen(address, timeout=30) as answer:
            read.append(answer.read())
        server[0].shutdown()

    server, opened = [], docs.open_server
    monkeypatch.setattr(docs.webbrowser, "open", browse)
    monkeypatch.setattr(docs, "open_server", lambda folder: server.append(opened(folder)) or server[0])
    docs.docs(["osc"])
    assert read == [b"<title>reference/osc/index.html</title>"]
