"""The page of `live studio` before a show runs: what it offers, what it takes, and who may ask."""

import asyncio
import json
import shutil
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import aiohttp
import pytest

from live.app.services.listening_socket import listening_socket
from live.app.services.studio_start import chosen_show, start_facts
from live.base.errors import PersonError
from live.control.web.start_server import StartServer
from live.show.patch.patch_search_path import PATCHES

KEY = "a-key-of-the-tests-4711"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "songs").mkdir()
    (tmp_path / ".hidden").mkdir()
    shutil.copy(PATCHES / "music" / "first_show.ogg", tmp_path / "songs" / "a song.ogg")
    shutil.copytree(PATCHES / "contemporary", tmp_path / "mine")
    shutil.copy(PATCHES / "first_show.toml", tmp_path / "one.toml")
    (tmp_path / "notes.toml").write_text("x = 1")
    return tmp_path


def test_a_folder_offers_its_songs_and_shows(folder: Path) -> None:
    facts = start_facts(folder, "new one")
    assert (facts["songs"], facts["shows"], facts["name"]) == (["songs/a song.ogg"], ["mine", "one.toml"], "new one")
    assert "samba" in facts["examples"]


@pytest.mark.parametrize(
    "values",
    [
        None, 5, [], {}, {"name": "x"}, {"name": "../x", "example": "samba"}, {"name": "", "example": "samba"},
        {"name": "x" * 61, "example": "samba"}, {"name": ".x", "example": "samba"}, {"open": "../mine"},
        {"open": "songs"}, {"name": "x", "song": "/etc/passwd"}, {"name": "x", "song": "../a.ogg"},
        {"name": "x", "example": "no"}, {"name": "mine", "example": "samba"}, {"name": "x", "example": "samba", "y": 1},
        {"name": "x", "song": "songs/a song.ogg", "dancers": 0}, {"name": "x\n", "example": "samba"},
        {"name": "x", "song": "songs/a song.ogg", "dancers": "12"},
    ],
)  # fmt: skip
def test_what_cannot_be_chosen_is_refused(folder: Path, values: object) -> None:
    before = sorted(folder.iterdir())
    with pytest.raises(PersonError):
        chosen_show(folder, start_facts(folder), values)
    assert sorted(folder.iterdir()) == before


def test_a_show_is_opened_or_made(folder: Path) -> None:
    facts = start_facts(folder)
    assert chosen_show(folder, facts, {"open": "one.toml"}) == str(folder / "one.toml")
    assert chosen_show(folder, facts, {"name": "né 2", "example": "pairs"}) == str(folder / "né 2")
    assert (folder / "né 2" / "show.toml").is_file()


def served(ask: Callable[[aiohttp.ClientSession, str, "asyncio.Task[str]"], Awaitable[None]]) -> str:
    """Run a server whose choices are echoed, or refused if they are empty; return what was chosen."""

    def choose(values: Any) -> str:
        if not values:
            raise PersonError("nothing", "something")
        return json.dumps(values)

    async def run() -> str:
        with listening_socket(("127.0.0.1", 0), 16, resumes=False) as listening:
            port = listening.getsockname()[1]
            task = asyncio.ensure_future(StartServer(listening, KEY, {"songs": []}, choose).run())
            async with aiohttp.ClientSession() as client:
                await ask(client, f"http://127.0.0.1:{port}", task)
            return await asyncio.wait_for(task, 30)

    return asyncio.run(asyncio.wait_for(run(), 60))


def test_the_choice_of_a_page_ends_the_server() -> None:
    async def ask(client: aiohttp.ClientSession, at: str, task: "asyncio.Task[str]") -> None:
        bearer = {"Authorization": f"Bearer {KEY}"}
        async with client.get(f"{at}/surface.json", headers=bearer) as answer:
            assert await answer.json() == {"start": {"songs": []}}
        async with client.get(f"{at}/studio") as answer:
            assert answer.status == 200
            assert "script-src 'self'" in answer.headers["Content-Security-Policy"]
        for path, headers, status in (
            ("/surface.json", {}, 401), ("/surface.json", {"Authorization": "Bearer wrong"}, 401),
            ("/other", bearer, 404),
            ("/studio/start", bearer, 400), ("/surface.json", bearer | {"Origin": "http://evil.example"}, 403),
            ("/surface.json", bearer | {"Host": "evil.example"}, 403), ("/studio/start", {}, 401),
        ):  # fmt: skip
            async with client.get(at + path, headers=headers) as answer:
                assert answer.status == status, path
        async with client.post(f"{at}/surface.json", headers=bearer) as answer:
            assert answer.status == 405
        async with client.ws_connect(f"{at}/studio/start", protocols=("live.operator", f"live.key.{KEY}")) as page:
            for text in ("", "{", "[" * 2000, "{}"):
                await page.send_str(text)
                assert (await page.receive_json())["kind"] == "refused"
            await page.send_str('{"open": "x"}')
            assert (await page.receive_json())["kind"] == "made"
        await asyncio.wait_for(asyncio.shield(task), 30)

    assert json.loads(served(ask)) == {"open": "x"}
