"""Documents refer only to existing files."""

import re
from pathlib import Path

import av
import pytest

from tests.places import ROOT
from tools.docs_films.film_file import POSTER_BYTES
from tools.draw_docs_films import FILMS, FOLDER, WEBP_BYTES, files_of
from tools.reference.reference_pages import reference_pages

MADE = {ROOT / "docs/reference" / path for path in reference_pages()}
"""Pages that are made when the site is built."""
DOCUMENTS = sorted(
    path
    for part in ("*.md", "docs/**/*.md", "bench/*.md", "patches/**/*.md", "tests/**/*.md", "live/**/*.md")
    for path in ROOT.glob(part)
    if path not in MADE and not path.is_relative_to(ROOT / "live/site")
)
ENDINGS = "\n".join(path.as_posix() for part in ("live", "tests") for path in (ROOT / part).rglob("*.py")) + "\n"
EXAMPLE = re.compile(r"```diff\nnew .*?```", re.DOTALL)
"""A file that a worked example adds."""
NAMED = re.compile(
    r"(?<![\w/~.-])((?:live|tests|docs|bench|patches|tools)/[\w./-]+\.[a-z]{2,6}|[a-z_]+/[a-z_/]+\.py)(?![\w/-])"
)
LINKED = re.compile(r"\]\((?!https?:|mailto:|#)([^)#\s]+)")
"""The target of a link, without its fragment."""


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_files_named_by_documents_exist(document: Path) -> None:
    text = EXAMPLE.sub("", document.read_text(encoding="utf-8"))
    missing = [
        name
        for pattern in (NAMED, LINKED)
        for name in pattern.findall(text)
        if not any((base / name).exists() or (base / name).resolve() in MADE for base in (ROOT, document.parent))
        and f"/{name}\n" not in ENDINGS  # a package is often named without those above it
    ]
    assert not missing


_COMMENT = re.compile(r"(?m)(?:^|(?<=\s))#.*$")
_CODE_WORD = re.compile(r"`([A-Za-z_][\w.]*)(?:\(\))?`")
_FOREIGN_WORDS = frozenset(
    (
        "shm_open",
        "betas",
        "LeftShoulder",
        "LeftLeg",
        "LeftUpLeg",
        "LeftFoot",
        "LeftAnkle",
        "lwrist",
        "lhand",
        "glTF",
        "ink_width",
        "Danca",
    )
)
"""Names of other programs, file formats and patches in docstrings."""


def test_docstrings_name_code_that_exists() -> None:
    """A name in backticks with an underscore, a dot or a capital is a name of the code, or a word of its texts."""
    names, quoted = set(_FOREIGN_WORDS), []
    for path in (path for folder in ("live", "bench", "tools") for path in (ROOT / folder).rglob("*.py")):
        names |= {path.stem, *path.parts}
        code, texts = [], []
        for index, part in enumerate(path.read_text(encoding="utf-8").split('"""')):
            if index % 2:
                texts.append(part)
            else:
                code.append(_COMMENT.sub("", part))
                texts += _COMMENT.findall(part)
        names.update(re.findall(r"\w+", " ".join(code)))
        quoted += [(path.relative_to(ROOT).as_posix(), word) for text in texts for word in _CODE_WORD.findall(text)]
    stale = [
        f"{where}: {word}"
        for where, word in quoted
        if word.isascii() and re.search(r"[A-Z_.]", word) and not set(word.split(".")) <= names
    ]
    assert stale == []


def test_films_are_those_of_their_tool_and_small() -> None:
    """All files of docs/films/ come from the tool, have a caption, and fit on a page."""
    expected = {path for name in FILMS for path in files_of(name)}
    found = {path.relative_to(FOLDER) for path in FOLDER.rglob("*") if path.is_file() and path.suffix != ".toml"}
    assert found == {*expected, Path("README.md")}
    limits = {".mp4": 400_000, ".jpg": POSTER_BYTES, ".webp": WEBP_BYTES}
    size = {path: (FOLDER / path).stat().st_size for path in expected}
    assert [path for path in expected if not 1_000 < size[path] <= limits[path.suffix]] == []
    assert sum(size[path] for path in expected if path.suffix == ".mp4") <= 4_000_000
    captions = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert [name for name in FILMS if f"`{name}.mp4`" not in captions] == []
    for folder in (FOLDER, *(path for path in FOLDER.rglob("*") if path.is_dir())):
        assert len(list(folder.iterdir())) <= 25, folder


@pytest.mark.parametrize("name", FILMS)
def test_films_play_on_web_pages(name: str) -> None:
    """H.264 in 4:2:0, 25 pictures a second, silent, 6 to 12 seconds or so, with the index before the pictures."""
    film = FOLDER / files_of(name)[0]
    data = film.read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")
    with av.open(str(film)) as container:
        (stream,) = container.streams
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == ("h264", "yuv420p")
        assert 5.0 <= stream.frames / stream.average_rate <= 12.2
