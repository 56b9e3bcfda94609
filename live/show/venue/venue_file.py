"""What was measured, brought into the text of a venue's file so that all that a person wrote in it stays as it is."""

from collections.abc import Mapping
from pathlib import Path

import tomlkit
from tomlkit.exceptions import TOMLKitError

from live.base.errors import PersonError
from live.show.patch.patch_search_path import is_file
from live.show.patch.toml_file import parse_model, read_text
from live.show.venue.venue import Venue

HEAD = "# A venue: what is true of the hall and not of the show.\n\n"


def with_values(text: str, name: str, values: Mapping[str, Mapping[str, object]], comment: str) -> str:
    """The TOML `text` (empty for a new file) with `values` by table and key; comments and all else are kept.

    `comment` stands behind each of the lines that are new or changed.
    """
    document = tomlkit.parse(text or f"{HEAD}name = {tomlkit.item(name).as_string()}\n")
    for table, keys in values.items():
        if table not in document:
            document[table] = tomlkit.table()
        section = document[table]
        for key, value in keys.items():
            if section.get(key) == value:
                continue
            section[key] = value
            section[key].comment(comment)
    return tomlkit.dumps(document)


def changed_venue(path: Path, name: str, values: Mapping[str, Mapping[str, object]], comment: str) -> str:
    """The text that the venue's file gets; PersonError if what is there is wrong."""
    before = read_text(path, "venue") if is_file(path) else ""
    parse_model(before, str(path), Venue, "venue")
    try:
        text = with_values(before, name, values, comment)
    except TOMLKitError as error:
        raise PersonError(f"{path}: {error}", "write the measured values into it yourself") from None
    parse_model(text, str(path), Venue, "venue")
    return text
