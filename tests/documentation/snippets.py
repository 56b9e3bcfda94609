"""Snippets of the documentation: its code blocks, with their pages and what a hidden comment says of them.

A comment `% toml: KIND` above a block of TOML says what file it is from. Without one the block is part of a patch, in
which there are the groups ember and mist if it has none; a comment `% with: section = [{ name = "solo" }]` adds what
else it needs. A block of the language `console` has commands to type, a line each; what follows a blank and a # is a
remark.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from tests.places import ROOT

_NOT_WRITTEN: Final = re.compile(
    r"docs/(decisions/|reference/(bridges|commands|osc|patch)/|reference/(keys|sketches)\.md)"
)
"""Pages for those who read the code, and pages that are made."""
PAGES: Final = sorted(
    path
    for part in ("README.md", "docs/**/*.md", "live/bridges/*/README.md", "patches/**/README.md")
    for path in ROOT.glob(part)
    if not _NOT_WRITTEN.match(path.relative_to(ROOT).as_posix())
)
_BLOCK: Final = re.compile(
    r"(?:^%[ ]*(?P<note>[^\n]*)\n)?^```(?P<language>[\w-]*)\n(?P<text>.*?)^```", re.DOTALL | re.MULTILINE
)


@dataclass(frozen=True)
class Snippet:
    """A code block of a page."""

    page: str
    line: int
    language: str
    note: str
    text: str

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"


def snippets(language: str) -> Iterator[Snippet]:
    """Yield all code blocks of a language."""
    for path in PAGES:
        text = path.read_text(encoding="utf-8")
        for block in _BLOCK.finditer(text):
            if block["language"] == language:
                line = text.count("\n", 0, block.start("text"))
                yield Snippet(path.relative_to(ROOT).as_posix(), line, language, block["note"] or "", block["text"])


def commands(program: str = "live") -> Iterator[tuple[Snippet, str]]:
    """Yield all commands of a program that pages tell to type, without remarks; continued lines are joined."""
    for snippet in snippets("console"):
        for line in snippet.text.replace("\\\n", " ").splitlines():
            typed = re.split(r"\s+#", line)[0].strip().removeprefix("$ ")
            if typed.split(" ")[0] == program:
                yield snippet, typed
