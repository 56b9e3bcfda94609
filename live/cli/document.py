"""Commands `live document edit | log | undo | redo | restore`: edits of a show's files, and their history."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from live.document.document_store import Accepted, DocumentStore
    from live.document.edit import Edit

app = typer.Typer(help="Edit a show's files step by step, undo, and return to earlier versions.", no_args_is_help=True)
SHOW = Annotated[str, typer.Argument(help="A patch: a file, a folder, or one of the project's by name.")]
BY = Annotated[str | None, typer.Option(help="Who edits; the history and undo tell people apart.", metavar="NAME")]
JSON = Annotated[bool, typer.Option("--json", help="Print the answers as JSON.")]


@app.command("edit")
def edit(
    show: SHOW,
    edits: Annotated[str, typer.Argument(help="A JSON file with a list of edits, or - for the standard input.")],
    dry: Annotated[
        bool, typer.Option("--dry", help="Check the edits, one after the other, and write nothing.")
    ] = False,
    by: BY = None,
    as_json: JSON = False,
) -> None:
    """Apply edits in order: {"do": "set", "at": ["group", "ember", "colour"], "value": [1, 0.4, 0.1]}.

    Each is accepted, saved and can be undone, or it is refused with the reasons and changes nothing. Exit 1 if one was
    refused.
    """
    from live.base.errors import PersonError
    from live.document.edit import parse_edits

    what = "the standard input" if edits == "-" else edits
    try:
        text = sys.stdin.read() if edits == "-" else Path(edits).read_text("utf-8")
    except (OSError, ValueError) as error:
        raise PersonError(f"cannot read the edits {what}: {error}") from None
    parsed = parse_edits(text, what)
    answers = _apply_all(_open(show, dry=dry), parsed, by or "")
    if as_json:
        print(json.dumps(answers, ensure_ascii=False))
    else:
        for number, answer in enumerate(answers, start=1):
            _print_answer(number, answer, dry=dry)
    if any("refused" in answer for answer in answers):
        raise typer.Exit(1)


def _open(show: str, *, dry: bool = False) -> "DocumentStore":
    """Open the document of a show, with the checks of `live check`."""
    from rich.console import Console

    from live.app.machine.kernel_warmup import warm_kernels
    from live.document.document_store import DocumentStore
    from live.show.patch.patch_search_path import find_patch

    path = find_patch(show)
    warm_kernels(Console(stderr=True))
    from live.app.bridges import installed_bridges
    from live.document.show_check import ShowCheck

    tables = installed_bridges().patch_tables()
    return DocumentStore(path, tables=tables, check=ShowCheck(path), date=_date, dry=dry)


def _date() -> str:
    from datetime import datetime

    return datetime.now().astimezone().isoformat(timespec="seconds")


def _apply_all(store: "DocumentStore", edits: "list[Edit]", by: str) -> list[dict[str, Any]]:
    from dataclasses import replace

    from live.document.document_store import refused_json_values
    from live.document.edit import EditRefused

    answers = []
    for one in edits:
        try:
            answers.append(store.edit(replace(one, by=one.by or by)).to_json_values(one.id))
        except EditRefused as error:
            answers.append(refused_json_values(one.id, error))
    return answers


def _print_answer(number: int, answer: dict[str, Any], *, dry: bool) -> None:
    from live.document.edit import Fault

    if "refused" not in answer:
        print(f"edit {number}: " + ("would be accepted" if dry else f"revision {answer['revision']}"))
        return
    print(f"edit {number}: refused")
    for fault in answer["refused"]:
        print(f"  {Fault(**fault)}")


@app.command("log")
def log(show: SHOW, as_json: JSON = False) -> None:
    """List all revisions of a show: number, date, who, and what they changed."""
    from live.app.bridges import installed_bridges
    from live.document.document_store import DocumentStore
    from live.show.patch.patch_search_path import find_patch

    store = DocumentStore(find_patch(show), tables=installed_bridges().patch_tables(), date=_date)
    if as_json:
        print(json.dumps([revision.to_json_values() for revision in store.revisions], ensure_ascii=False))
        return
    for revision in store.revisions:
        print(f"{revision.number:5}  {revision.date:25}  {revision.by or '-':12}  {revision.text}")


@app.command("undo")
def undo(show: SHOW, by: BY = None, as_json: JSON = False) -> None:
    """Take back the last edit that is in force; with --by the last one of this person."""
    _return(show, as_json, lambda store: store.undo(by))


@app.command("redo")
def redo(show: SHOW, by: BY = None, as_json: JSON = False) -> None:
    """Repeat the edit that was undone last."""
    _return(show, as_json, lambda store: store.undo(by, redo=True))


@app.command("restore")
def restore(
    show: SHOW,
    revision: Annotated[int, typer.Argument(help="A number of `live document log`.")],
    by: BY = None,
    as_json: JSON = False,
) -> None:
    """Return to an earlier revision; what came after it stays in the history."""
    _return(show, as_json, lambda store: store.restore(revision, by or ""))


def _return(show: str, as_json: bool, action: "Any") -> None:
    from live.document.document_store import refused_json_values
    from live.document.edit import EditRefused

    try:
        accepted: Accepted = action(_open(show))
    except EditRefused as error:
        if as_json:
            print(json.dumps(refused_json_values(None, error), ensure_ascii=False))
        else:
            print(f"refused: {error}")
        raise typer.Exit(1) from None
    if as_json:
        print(json.dumps(accepted.to_json_values(None), ensure_ascii=False))
    else:
        print(f"revision {accepted.revision.number}: {accepted.revision.text}")
