"""Documents name only files that are there."""

import re
from pathlib import Path

import pytest

from tests.places import ROOT

DOCUMENTS = sorted(
    path
    for part in ("*.md", "docs/**/*.md", "bench/*.md", "patches/**/*.md", "tests/**/*.md", "live/**/*.md")
    for path in ROOT.glob(part)
)
ENDINGS = "\n".join(path.as_posix() for part in ("live", "tests") for path in (ROOT / part).rglob("*.py")) + "\n"
NAMED = re.compile(
    r"(?<![\w/~.-])((?:live|tests|docs|bench|patches|tools)/[\w./-]+\.[a-z]{2,6}|[a-z_]+/[a-z_/]+\.py)(?![\w/-])"
)
LINKED = re.compile(r"\]\((?!https?:|mailto:|#)([^)#\s]+)")
"""Where a link leads, without what it leads to inside."""


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_what_a_document_names_is_there(document: Path) -> None:
    text = document.read_text(encoding="utf-8")
    missing = [
        name
        for pattern in (NAMED, LINKED)
        for name in pattern.findall(text)
        if not any((base / name).exists() for base in (ROOT, document.parent))
        and f"/{name}\n" not in ENDINGS  # a package is often named without those above it
    ]
    assert not missing
