"""Reading a patch: from a TOML file, or a folder with show.toml, to a frozen Patch, with errors that name the line."""

import contextlib
import os
import tomllib
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from live.base.errors import PersonError
from live.base.toml_lines import error_line, line_of, toml_lines
from live.show.patch import Patch

PATCHES: Final = next(
    (
        folder
        for folder in (Path(__file__).resolve().parents[2] / "patches", Path(__file__).resolve().parents[1] / "patches")
        if folder.is_dir()
    ),
    Path("patches"),
)
"""The project's own patches: beside the package in a checkout, inside it when installed."""

DEFAULT_PATCH: Final = PATCHES / "first_show.toml"
MAX_BYTES: Final = 4_000_000
SHOWN_PROBLEMS: Final = 8


class PatchError(PersonError):
    """A patch that cannot be used: for each problem file, line, field, what was read and what is allowed."""


def find_patch(name: str | None) -> Path:
    """The file of a patch named on the command line: a path, a folder with show.toml, or one of the project's own."""
    if name is None:
        return DEFAULT_PATCH
    given = Path(name)
    for path in (given, given / "show.toml", PATCHES / name, PATCHES / name / "show.toml", PATCHES / f"{name}.toml"):
        if is_file(path):
            return path
    if os.path.isdir(name):
        raise PatchError(f"the folder {name!r} holds no show.toml", "put one there, or name a TOML file")
    folders = (path.parent.name for path in PATCHES.glob("*/show.toml"))
    known = ", ".join(sorted([*(path.stem for path in PATCHES.glob("*.toml")), *folders])) or "none"
    raise PatchError(
        f"there is no patch {name[:200]!r}",
        f"give a TOML file, a folder with show.toml, or one of the project's: {known}",
    )


def is_file(path: Path) -> bool:
    """Whether there is such a file; a name that no file can have (too long, a zero byte) is none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def find_beside(name: str, patch_path: Path) -> Path | None:
    """A file or folder that a patch names: in the patch's folder first, then in the project's patches."""
    for folder in (patch_path.parent, PATCHES):
        with contextlib.suppress(OSError, ValueError):  # a name that no file can have
            if (folder / name).exists():
                return folder / name
    return None


def read_patch(path: Path) -> Patch:
    """The patch in `path`; PatchError says what is wrong, where, and what is allowed."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise PatchError(f"{path}: {path.stat().st_size} bytes; a patch has at most {MAX_BYTES}")
        text = path.read_bytes().decode("utf-8")
    except OSError as error:
        raise PatchError(f"cannot read the patch {path}: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise PatchError(f"{path}: not a text in UTF-8 (byte {error.start})") from None
    return parse_patch(text, str(path))


def parse_patch(text: str, file: str) -> Patch:
    """The patch written in `text`; `file` is named in errors."""
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise PatchError(f"{file}, line {error_line(str(error), text)}: not valid TOML: {error}") from None
    except RecursionError:
        raise PatchError(f"{file}: not a patch: its brackets are nested too deep") from None
    try:
        return Patch.model_validate(data)
    except ValidationError as error:
        raise PatchError(_explain(error, text, file)) from None


def _explain(error: ValidationError, text: str, file: str) -> str:
    lines = toml_lines(text)
    problems = []
    for problem in error.errors(include_url=False):
        where = tuple(problem["loc"])
        field = ".".join(str(part + 1) if isinstance(part, int) else part for part in where) or "the patch"
        problems.append(f"{file}, line {line_of(lines, where)}: {field}: {_words(problem)}")
    more = len(problems) - SHOWN_PROBLEMS
    return "; ".join(problems[:SHOWN_PROBLEMS]) + (f"; and {more} more" if more > 0 else "")


def _words(problem: Any) -> str:
    """One problem in words: what was read, what is allowed."""
    kind, message, read = problem["type"], problem["msg"], problem["input"]
    if kind == "extra_forbidden":
        return f"unknown key; {_known_keys(problem['loc'])}"
    if kind == "missing":
        return "missing; it must be given"
    if kind == "value_error":
        return str(message).removeprefix("Value error, ")
    context = problem.get("ctx", {})
    if kind == "too_short":
        return f"at least {context['min_length']} expected, found {context['actual_length']}"
    if kind == "too_long":
        return f"at most {context['max_length']} expected, found {context['actual_length']}"
    if kind == "model_type":
        return f"a table expected, found {str(read)[:40]}"
    shown = repr(read) if isinstance(read, str | int | float | bool) else f"a {type(read).__name__}"
    return f"{message[:1].lower()}{message[1:]}, found {shown[:60]}"


def _known_keys(where: tuple[str | int, ...]) -> str:
    """The keys allowed where an unknown one stands, with the nearest spelling first if one is near."""
    import difflib

    model: Any = Patch
    for part in where[:-1]:
        if isinstance(part, int):
            continue
        annotation = model.model_fields[part].annotation
        inner = getattr(annotation, "__args__", None)
        model = inner[0] if inner else annotation
        if not hasattr(model, "model_fields"):
            return "see the reference"
    keys = list(model.model_fields)
    near = difflib.get_close_matches(str(where[-1]), keys, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    return f"{hint}allowed are {', '.join(keys)}"
