"""What to type where a text is no TOML: `tomllib` says what it met, and a person has to know what would do."""

import re
from typing import Final

_KEY: Final = re.compile(r"\('?(?P<key>.*?)'?,?\)")
_ASSIGNED: Final = re.compile(r"^\s*(?P<key>[^=\[]+?)\s*=\s*(?P<value>.*?)\s*$")
_REMEDIES: Final = (
    ("Unclosed inline table", "close it with } on the same line"),
    ("Unclosed array", "close it with ]"),
    ("Unterminated string", "close the text with the quotes that it begins with"),
    ("Unescaped '\\'", "write / or \\\\ for \\, or put the text into 'single quotes'"),
    ("Expected ']]'", "close the name of the table with ]]"),
    ("Expected ']'", "close the name of the table with ]"),
    ("Expected newline", "one key = value on each line, nothing behind the value; a number has a point: 9.5"),
    ("Expected '='", "a line is key = value; a key has no blanks, or stands in quotes"),
    ("Duplicate inline table key", "leave one of them out"),
    ("Cannot overwrite a value", "the key is there already: leave one of them out"),
    ("Cannot redefine namespace", "the name is there already: leave one of them out, or write [[ ]] each time"),
    ("Cannot mutate immutable", "write all its keys where it stands first"),
    ("Invalid date or datetime", "text stands in quotes"),
    ("Invalid hex value", "a colour or other text stands in quotes"),
    ("Invalid initial character for a key", "a key is of letters, digits, - and _, or stands in quotes"),
    ("Invalid statement", "a line is key = value, [table], [[table]], or begins with #"),
    ("Illegal character", "close the text with quotes on the same line"),
    ("Found invalid character", "leave that character out"),
)


def toml_remedy(message: str, text: str, line: int) -> str:
    """What would mend what a `tomllib.TOMLDecodeError` says of `line` (from 1) of `text`."""
    lines = text.splitlines()
    written = lines[line - 1] if 0 < line <= len(lines) else ""
    if message.startswith("Cannot declare"):
        found = _KEY.search(message)
        key = "table" if found is None else found["key"].replace("', '", ".")
        return f"write [[{key}]] each time where there may be several, else all its keys under one [{key}]"
    if message.startswith("Invalid value"):
        return _of_value(written)
    return next((remedy for begins, remedy in _REMEDIES if message.startswith(begins)), "a line is key = value")


def _of_value(written: str) -> str:
    """What would do in place of the value of a line."""
    found = _ASSIGNED.match(written)
    value = "" if found is None else found["value"].partition("#")[0].strip()
    if value.lower() in ("true", "false"):
        return f"write {value.lower()}"
    if value.startswith(("“", "”", "„", "‘", "’", "«", "»")):
        return 'text stands in plain quotes: "..."'
    if re.fullmatch(r"[+-]?(\.[0-9]+|[0-9]+\.)", value):
        return "a number has a digit on both sides of its point: 0.5"
    if found is not None and not value:
        return "a value is missing behind ="
    if re.fullmatch(r"[^\W\d][\w /.:*-]*", value) and found is not None:
        return f'text stands in quotes: {found["key"]} = "{value[:60]}"'
    return "text stands in quotes, lists in [ ]; true and false are written small"
