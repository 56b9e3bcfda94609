"""Whatever the documentation tells to type or to write is accepted: commands, parts of patches, OSC addresses.

`tests/end_to_end/test_tour.py` runs the commands; here they are only parsed.
"""

import json
import re
import shlex
import tomllib
from functools import cache

import pytest
import typer

from live.app.bridges import installed_bridges
from live.app.option_values import expand_optional_values
from live.base.errors import PersonError
from live.cli.main import app
from live.control.osc.osc_output import MESSAGES, PREFIX
from live.control.registry.registry import READINGS, REGISTRY
from live.show.patch.patch_reader import parse_patch
from tests.documentation.snippets import PAGES, commands, snippets
from tests.places import ROOT

PATCH_HEAD = 'name = "excerpt"\n'
GROUP = """
[[group]]
name = "ember"
dancers = 12
steps = ["groove"]
[[group]]
name = "mist"
dancers = 6
steps = ["groove"]
"""
"""Groups for parts of patches that have none."""
OTHER_FILES = ("step", "venue", "pairs", "take", "character", "excerpt")
"""Kinds of TOML that are no patches; an excerpt is a part of one of them."""
_ADDRESS = re.compile(r"(?<![\w.])/dance/[a-z_/0-9]+")


@cache
def whole_program():
    """The command `live` with all of its commands."""
    return typer.main.get_command(app)


def parse_command(typed):
    """Parse a command line as `live` does, without running it."""
    words = expand_optional_values(shlex.split(typed)[1:])
    command = whole_program()
    while hasattr(command, "commands") and words:
        if words[0].startswith("-"):
            assert command.invoke_without_command, f"{command.name} needs one of its commands"
            break
        name, *words = words
        assert name in command.commands, f"there is no command {name}"
        command = command.commands[name]
    command.make_context(command.name, words)


@pytest.mark.parametrize(("snippet", "typed"), [pytest.param(*each, id=each[1]) for each in commands()])
def test_commands_are_accepted(snippet, typed):
    try:
        parse_command(typed)
    except typer.Exit:
        pass
    except Exception as error:
        pytest.fail(f"{snippet}: {getattr(error, 'message', error)}")


@pytest.mark.parametrize("snippet", list(snippets("toml")), ids=str)
def test_parts_of_patches_are_accepted(snippet):
    word, _, note = snippet.note.partition(":")
    tables = tomllib.loads(snippet.text)
    if word == "toml":
        assert note.strip() in OTHER_FILES
        return
    head = "" if "name" in tables else PATCH_HEAD
    head += f"{note.strip()}\n" if word == "with" else ""
    try:
        parse_patch(
            head + snippet.text + ("" if "group" in tables else GROUP), str(snippet), installed_bridges().patch_tables()
        )
    except PersonError as error:
        pytest.fail(f"{snippet}: {error}")


@pytest.mark.parametrize("snippet", list(snippets("json")), ids=str)
def test_json_is_json(snippet):
    json.loads(snippet.text)


def known_addresses():
    """Return all addresses that exist, with those of messages that the show sends."""
    return (
        {control.address for control in REGISTRY}
        | {reading.address for reading in READINGS}
        | {PREFIX + name for name, *_ in MESSAGES}
    )


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_addresses_exist(path):
    known = known_addresses()
    unknown = {
        address.rstrip("/")
        for address in _ADDRESS.findall(path.read_text(encoding="utf-8"))
        if REGISTRY.resolve(address.rstrip("/"))[0] is None
        and not any(each == address or each.startswith(address.rstrip("/") + "/") for each in known)
    }
    assert not unknown
