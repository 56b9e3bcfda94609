"""Pages of the command line's reference, made from the commands themselves: one for each command."""

from collections.abc import Iterator
from typing import Any, Final

import typer

from live.cli.main import HALL, PANELS, app

ARGUMENTS: Final = "Arguments"
OPTIONS: Final = "Options"

INDEX: Final = """# Commands

`live COMMAND --help` prints what stands here. Exit codes: 0 done, 1 a check failed, 2 something to correct in what was
given, 130 ended by Ctrl-C.
"""


def _cell(text: str) -> str:
    """Return a text for a cell of a table; `<name>` stays what it is."""
    return " ".join(text.split()).replace("|", r"\|").replace("<", r"\<").replace("[", r"\[").replace("*", r"\*")


def _default(parameter: Any) -> str:
    value = parameter.default
    if value in (None, False, (), "") or callable(value) or parameter.required:
        return ""
    return f" (default: {getattr(value, 'value', value)})"


def _rows(command: Any) -> Iterator[tuple[str, str]]:
    """Yield each parameter's panel and its row."""
    for parameter in command.params:
        if getattr(parameter, "hidden", False) or parameter.name in ("help", "install_completion", "show_completion"):
            continue
        text = _cell(getattr(parameter, "help", None) or "") + _default(parameter)
        if parameter.param_type_name == "argument":
            yield ARGUMENTS, f"| `{parameter.display_name_raw}` | {text} |"
            continue
        names = ", ".join(f"`{name}`" for name in (*parameter.opts, *parameter.secondary_opts))
        kind = "" if parameter.is_flag else (parameter.display_type_rich(_context(command)) or "").replace("|", r"\|")
        panel = getattr(parameter, "rich_help_panel", None) or OPTIONS
        yield panel, f"| {names}{f' `{kind}`' if kind else ''} | {text} |"


def _context(command: Any) -> Any:
    return command.context_class(command, info_name=command.name)


def _describe(path: str, command: Any, level: int) -> list[str]:
    """Return the lines of a command and those below it."""
    usage = " ".join([path, *command.collect_usage_pieces(_context(command))])
    lines = [
        f"{'#' * level} {path}",
        "",
        (command.help or "").replace("\b", "").strip(),
        "",
        "```text",
        usage,
        "```",
        "",
    ]
    panels: dict[str, list[str]] = {}
    for panel, row in _rows(command):
        panels.setdefault(panel, []).append(row)
    for panel, rows in panels.items():
        lines += [f"**{panel}**", "", "| name | meaning |", "|-|-|", *rows, ""]
    for name, below in getattr(command, "commands", {}).items():
        lines += _describe(f"{path} {name}", below, level + 1)
    return lines


def command_pages() -> dict[str, str]:
    """Return the pages by file name."""
    commands = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    panel_of = {name: panel for panel, names in PANELS.items() for name in names}
    pages, groups = {}, {panel: [] for panel in PANELS}  # type: dict[str, str], dict[str, list[str]]
    for name, command in commands.items():
        panel = panel_of.get(name, HALL)  # of a bridge
        about = command.get_short_help_str(limit=200)
        groups[panel].append(f"| [`live {name}`]({name}.md) | {_cell(about)} |")
        pages[f"{name}.md"] = "\n".join(_describe(f"live {name}", command, 1))
    index = [
        INDEX,
        "```{toctree}",
        ":maxdepth: 1",
        ":hidden:",
        "",
        *(page.removesuffix(".md") for page in pages),
        "```",
    ]
    for panel, rows in groups.items():
        index += ["", f"## {panel}", "", "| command | purpose |", "|-|-|", *rows]
    return {"index.md": "\n".join([*index, ""]), **pages}
