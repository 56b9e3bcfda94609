"""The command `live docs`: the documentation, which is part of the package, in the browser."""

import difflib
import functools
import http.server
import webbrowser
from pathlib import Path
from typing import Annotated, Any, Final

import typer

import live
from live.base.errors import PersonError
from live.control.worker_thread import WorkerThread

SITE: Final = Path(live.__file__).parent / "site"
"""The pages as built by `make docs`; packages have them, a checkout only then."""


def list_pages(site: Path) -> dict[str, str]:
    """Return the addresses of all pages by the ends of their paths; a folder's name is that of its first page."""
    pages: dict[str, str] = {}
    for file in sorted(site.rglob("*.html")):
        path = file.relative_to(site)
        named = path.parent if path.name == "index.html" else path.with_suffix("")
        if named.name and not path.parts[0].startswith("_"):
            for begin in range(len(named.parts)):
                pages.setdefault("/".join(named.parts[begin:]), path.as_posix())
    return pages


def find_page(site: Path, wanted: str) -> str:
    """Return the address of a page; with an address of OSC or other words, that of the search for it.

    PersonError if the pages are not there.
    """
    if not (site / "index.html").is_file():
        raise PersonError(f"{site}: the documentation is not built here", "make docs")
    if not wanted:
        return "index.html"
    pages = list_pages(site)
    name = wanted.strip().strip("/").removesuffix(".md").removesuffix(".html")
    if found := pages.get(name) or pages.get(name.replace(" ", "-").replace("_", "-").lower()):
        return found
    from urllib.parse import urlencode

    return f"search.html?{urlencode({'q': wanted})}"


class _Pages(http.server.SimpleHTTPRequestHandler):
    """Serves the pages, silently."""

    def log_message(self, format: str, *arguments: Any) -> None:
        """Print nothing."""


def open_server(site: Path) -> http.server.ThreadingHTTPServer:
    """Return a server of the pages, for this machine only, at a free port.

    A browser that was installed as a snap reads no hidden folders, where packages often lie, so that a file's address
    would not do.
    """
    return http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(_Pages, directory=str(site)))


def docs(
    page: Annotated[
        list[str] | None, typer.Argument(help="A page by its name, as osc or film, or words to search for.")
    ] = None,
    where: Annotated[bool, typer.Option("--where", help="Only print the page's file.")] = False,
) -> None:
    """Read the documentation in the browser, without a network: tutorials, how-to pages, reference, ideas."""
    wanted = " ".join(page or ())
    address = find_page(SITE, wanted)
    if where:
        if "?" in address:
            near = difflib.get_close_matches(wanted, [each for each in list_pages(SITE) if "/" not in each])
            raise PersonError(f"there is no page {wanted!r}", f"did you mean {' or '.join(near)}?" if near else None)
        print(SITE / address)
        return
    with open_server(SITE) as server:
        url = f"http://127.0.0.1:{server.server_address[1]}/{address}"
        print(f"{url}   (Ctrl-C ends it)", flush=True)
        pages = WorkerThread("pages", server.serve_forever)
        pages.start()  # before the browser: one of a terminal waits for the page, and returns when it ends
        try:
            webbrowser.open(url)
            pages.stop(timeout=None)  # when nothing is served any more: Ctrl-C
        finally:
            server.shutdown()
