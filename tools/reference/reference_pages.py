"""All pages of docs/reference/ that are made: commands, patch files, OSC and keys from tables, others from READMEs.

`python -m tools.reference.reference_pages` writes them, where Git ignores them; building the documentation does so by
itself.
"""

import re
from pathlib import Path
from typing import Final

from live.control.keyboard import KEYS
from tools.reference.command_pages import command_pages
from tools.reference.osc_pages import osc_pages
from tools.reference.patch_pages import patch_pages

ROOT: Final = Path(__file__).resolve().parents[2]
FOLDER: Final = ROOT / "docs" / "reference"

KEY_HEAD: Final = """# Keys

Keys of the window in which the show is seen. A key that changes the show has its [OSC address](osc/index.md) beside it.

| key | effect | address |
|-|-|-|
"""


BRIDGE_HEAD: Final = """# Bridges

Optional inputs and outputs. Each is a folder that the program finds when it starts, and does without.

```{toctree}
:maxdepth: 1
"""


def key_page() -> str:
    """Return the page of the keys."""
    rows = [
        f"| **{name}** | {key.description} | {f'`{key.command}`' if key.is_control else ''} |"
        for name, key in KEYS.items()
    ]
    return KEY_HEAD + "\n".join(rows) + "\n"


def bridge_pages() -> dict[str, str]:
    """Return the pages of the bridges by file name: each bridge holds its own, which links to docs/."""
    readmes = {path.parent.name: path.read_text(encoding="utf-8") for path in ROOT.glob("live/bridges/*/README.md")}
    pages = {
        f"{name}.md": re.sub(r"\]\(\.\./(\w+)/README\.md", r"](\1.md", text.replace("](../../../docs/", "](../../"))
        for name, text in sorted(readmes.items())
    }
    return {"index.md": "\n".join([BRIDGE_HEAD, *sorted(readmes), "```\n"]), **pages}


def reference_pages() -> dict[str, str]:
    """Return all pages by their paths below docs/reference/."""
    sketches = (ROOT / "patches" / "steps" / "README.md").read_text(encoding="utf-8")
    pages = {"keys.md": key_page(), "sketches.md": sketches.replace("](../../docs/", "](../")}
    for folder, make in FOLDERS.items():
        pages |= {f"{folder}/{name}": text for name, text in make().items()}
    return pages


FOLDERS: Final = {"bridges": bridge_pages, "commands": command_pages, "osc": osc_pages, "patch": patch_pages}
"""Folders of which every page is made."""


def write_pages() -> None:
    """Write those that have changed, and remove those that are no longer made."""
    pages = reference_pages()
    for path, text in pages.items():
        file = FOLDER / path
        if not file.is_file() or file.read_text(encoding="utf-8") != text:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
    for file in [file for name in FOLDERS for file in (FOLDER / name).glob("*.md")]:
        if file.relative_to(FOLDER).as_posix() not in pages:
            file.unlink()


if __name__ == "__main__":
    write_pages()
