"""The site as it is built: no dead link, two clicks to anything, search that finds, no finding of axe."""

import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag, urljoin

import pytest

from live.cli.docs import open_server
from tests.end_to_end.browser import browser, needs_browser
from tests.places import ROOT

AXE = ROOT / "studio" / "node_modules" / "axe-core" / "axe.min.js"
needs_axe = pytest.mark.skipif(
    not AXE.is_file(), reason="needs the packages of studio/ (make test installs them where npm is)"
)
pytestmark = [pytest.mark.long, pytest.mark.xdist_group("site")]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built anew."""
    out = tmp_path_factory.mktemp("site")
    build = [sys.executable, "-m", "sphinx", "-q", "--fail-on-warning", "--keep-going", "-b", "html"]
    done = subprocess.run([*build, "-d", str(out / "trees"), "docs", str(out / "html")], cwd=ROOT, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()
    return out / "html"


@pytest.fixture(scope="module")
def address(site: Path) -> Iterator[str]:
    """Where the site is served, as `live docs` does."""
    with open_server(site) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_address[1]}/"
        server.shutdown()
        thread.join()


class _Page(HTMLParser):
    """Links, sources and anchors of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: set[str] = set()
        self.sources: set[str] = set()
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.anchors.add(values.get("id") or "")
        if tag == "a" and values.get("href"):
            self.links.add(str(values["href"]))
        self.sources |= {str(values[key]) for key in ("src", "poster") if values.get(key)}


def _pages(site: Path) -> dict[str, _Page]:
    return {
        path.relative_to(site).as_posix(): _Page(path.read_text(encoding="utf-8"))
        for path in site.rglob("*.html")
        if not path.relative_to(site).parts[0].startswith("_")
    }


def test_no_link_and_no_picture_is_dead(site: Path) -> None:
    pages = _pages(site)
    dead = []
    for name, page in pages.items():
        for link in page.links | page.sources:
            if re.match(r"[a-z]+:", link):
                continue
            path, anchor = urldefrag(urljoin(name, link))
            path = path.partition("?")[0]
            if not (site / unquote(path)).is_file() or (anchor and path in pages and anchor not in pages[path].anchors):
                dead.append(f"{name}: {link}")
    assert not dead


def test_two_clicks_lead_anywhere(site: Path) -> None:
    pages = _pages(site)
    one = {urldefrag(link)[0] for link in pages["index.html"].links} & set(pages)
    two = one | {urldefrag(urljoin(name, link))[0] for name in one for link in pages[name].links}
    assert set(pages) - two - {"index.html", "search.html", "genindex.html"} == set()


@needs_browser
@pytest.mark.browser
@pytest.mark.parametrize(("words", "found"), [("crossing", "OSC: elements"), ("pedal", "MIDI"), ("blackout", "Keys")])
def test_search_finds_without_a_network(address: str, words: str, found: str) -> None:
    with browser() as (chromium, _):
        page = chromium.new_page()
        page.goto(f"{address}search.html?q={words.replace(' ', '+')}")
        page.locator("ul.search li").first.wait_for(timeout=60_000)
        page.wait_for_function("document.querySelector('.search-summary').textContent.includes('found')")
        assert found.lower() in page.locator("ul.search").inner_text().lower()


@needs_browser
@needs_axe
@pytest.mark.browser
@pytest.mark.parametrize(("scheme", "width"), [("light", 1280), ("dark", 1280), ("light", 390)])
def test_axe_finds_nothing(site: Path, address: str, scheme: str, width: int) -> None:
    """Every written page on a screen, and one of each kind that is made; on a phone some."""
    made = {"reference/osc/clock.html", "reference/patch/group.html", "reference/commands/play.html"}
    phone = {"index.html", "search.html", *made}
    names = [
        name for name in sorted(_pages(site)) if name in made or not re.match(r"reference/(commands|osc|patch)/", name)
    ]
    findings = []
    with browser() as (chromium, _):
        page = chromium.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme).new_page()
        for name in names if width > 1000 else sorted(phone):
            page.goto(address + name)
            page.add_script_tag(path=AXE)
            found = page.evaluate("axe.run().then(r => r.violations.map(v => `${v.id}: ${v.nodes[0].html}`))")
            findings += [f"{name}: {each}" for each in found]
    assert not findings
