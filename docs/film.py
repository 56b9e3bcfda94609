"""Sphinx's directive `film`: a film of docs/films/ with its caption, as a moving picture in a page.

    ```{film} canon
    ```

Films play silently while they are seen, unless the reader prefers less motion (docs/site.js).
"""

import html
import re
import shutil
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

FILMS = Path(__file__).resolve().parent / "films"


def read_captions() -> dict[str, str]:
    """Return the captions of all films by name, as docs/films/README.md has them."""
    text = (FILMS / "README.md").read_text(encoding="utf-8")
    return dict(re.findall(r"^\| `([\w/-]+)\.mp4` \| (.+) \|$", text, re.MULTILINE))


class Film(SphinxDirective):
    """A film by its name; a name that is not there ends the build."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the figure."""
        name = self.arguments[0]
        caption = read_captions().get(name)
        poster = (FILMS / name).parent / "posters" / f"{Path(name).name}.jpg"
        if caption is None or not (FILMS / f"{name}.mp4").is_file() or not poster.is_file():
            raise self.error(f"there is no film {name!r} with a poster and a caption in docs/films/")
        self.env.note_dependency(str(FILMS / "README.md"))
        folder = "../" * self.env.docname.count("/") + "films"
        still = poster.relative_to(FILMS).as_posix()
        text = html.escape(caption)
        shown = "" if name.startswith("gallery/") else f"<figcaption>{text}</figcaption>"
        return [
            nodes.raw(
                "",
                f'<figure class="film"><video src="{folder}/{name}.mp4" poster="{folder}/{still}" aria-label="{text}"'
                f' preload="none" muted loop playsinline controls></video>{shown}</figure>',
                format="html",
            )
        ]


def copy_films(app: Any, failed: Exception | None) -> None:
    """Copy films and posters beside the pages."""
    if failed is None:
        shutil.copytree(
            FILMS,
            Path(app.outdir) / "films",
            dirs_exist_ok=True,
            ignore=shutil.ignore_patterns("*.md", "*.toml", "*.webp"),
        )


def setup(app: Any) -> dict[str, bool]:
    """Add the directive."""
    app.add_directive("film", Film)
    app.connect("build-finished", copy_films)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
