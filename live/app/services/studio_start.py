"""`live studio` without a show: a page on which one is begun, from a song or an example, or opened."""

import asyncio
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from live.app.services.listening_socket import page_socket
from live.app.services.new_show import MAX_DANCERS, examples, make_show
from live.base.errors import PersonError
from live.control.web.http_protection import BACKLOG
from live.control.web.start_server import StartServer
from live.show.patch.patch_search_path import MAIN_FILE

SONGS: Final = frozenset({".wav", ".flac", ".ogg", ".opus", ".mp3", ".m4a", ".aac", ".aif", ".aiff"})
MAX_LISTED: Final = 200
MAX_SCANNED: Final = 5000
"""Entries of the folder that are looked at."""


class Choice(BaseModel):
    """What a page has chosen; songs and shows are those that it was told."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)
    open: Annotated[str, Field(max_length=500)] | None = None
    """A show that is there."""
    name: Annotated[str, Field(pattern=r"^[^\W_][\w .-]{0,59}$")] | None = None
    """The folder of a new one."""
    song: Annotated[str, Field(max_length=500)] | None = None
    dancers: Annotated[int, Field(ge=1, le=MAX_DANCERS)] | None = None
    example: Annotated[str, Field(max_length=100)] | None = None


def start_facts(folder: Path, wanted: str = "") -> dict[str, Any]:
    """Return what there is in a folder to choose from: songs and shows, by their paths in it, and the examples."""
    songs, shows = [], []
    entries = sorted(path for path, _ in zip(folder.glob("*"), range(MAX_SCANNED), strict=False))
    for path in entries:
        if path.name.startswith("."):
            continue
        if path.is_dir():
            if (path / MAIN_FILE).is_file():
                shows.append(path.name)
            inner = (each for each, _ in zip(path.glob("*"), range(MAX_SCANNED), strict=False))
            songs += sorted(f"{path.name}/{each.name}" for each in inner if each.suffix.lower() in SONGS)
        elif path.suffix.lower() in SONGS:
            songs.append(path.name)
        elif path.suffix == ".toml" and _is_show(path):
            shows.append(path.name)
    return {
        "folder": str(folder), "name": wanted, "songs": songs[:MAX_LISTED], "shows": shows[:MAX_LISTED],
        "examples": examples(), "most_dancers": MAX_DANCERS,
    }  # fmt: skip


def _is_show(path: Path) -> bool:
    try:
        return "[[group]]" in path.read_text("utf-8", errors="replace")
    except OSError:
        return False


def chosen_show(folder: Path, facts: dict[str, Any], values: object) -> str:
    """Return the path of the show that a page has chosen, which is made first if it is a new one; PersonError for
    what cannot be chosen."""
    try:
        choice = Choice.model_validate(values)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"][:2]))
        if where == "name":
            raise PersonError(
                "a name of letters, digits, blanks and - expected", "it becomes the show's folder"
            ) from None
        raise PersonError(f"{where or 'choice'}: {first['msg'][:200]}") from None
    if choice.open is not None:
        if choice.open not in facts["shows"]:
            raise PersonError(f"there is no show {choice.open[:100]!r} any more")
        return str(folder / choice.open)
    if choice.name is None:
        raise PersonError("a new show needs a name")
    if choice.song is not None and choice.song not in facts["songs"]:
        raise PersonError(f"there is no song {choice.song[:100]!r} any more")
    song = None if choice.song is None else folder / choice.song
    made = make_show(folder / choice.name.strip(), song=song, dancers=choice.dancers, example=choice.example)
    return str(made.parent)


def choose_show(folder: Path, wanted: str, where: tuple[str, int], key: str) -> str:
    """Serve the page at an address until a show was chosen; return its path. PersonError if nobody can listen there."""
    facts = start_facts(folder, wanted)

    async def run() -> str:
        with page_socket(where, BACKLOG) as listening:
            return await StartServer(listening, key, facts, lambda values: chosen_show(folder, facts, values)).run()

    return asyncio.run(run())
