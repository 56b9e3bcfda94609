"""Commands `live document edit | log | undo | redo | restore | keep`: edits of a show's files, and their history."""

import contextlib
import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

if TYPE_CHECKING:
    from live.app.document_remote import RemoteDocument
    from live.document.document_store import Accepted, DocumentStore
    from live.document.edit import Edit

app = typer.Typer(help="Edit a show's files step by step, undo, and return to earlier versions.", no_args_is_help=True)
SHOW = Annotated[str, typer.Argument(help="A patch: a file, a folder, or one of the project's by name.")]
BY = Annotated[str | None, typer.Option(help="Who edits; the history and undo tell people apart.", metavar="NAME")]
TO = Annotated[
    str | None,
    typer.Option(help="Speak to the show that runs there, instead of its files here.", metavar="HOST:PORT"),
]
JSON = Annotated[bool, typer.Option("--json", help="Print the answers as JSON.")]


@app.command("edit")
def edit(
    show: SHOW,
    edits: Annotated[str, typer.Argument(help="A JSON file with a list of edits, or - for the standard input.")],
    dry: Annotated[
        bool, typer.Option("--dry", help="Check the edits, one after the other, and write nothing.")
    ] = False,
    by: BY = None,
    to: TO = None,
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
    if to is not None:
        if dry:
            raise PersonError("--dry with --to: a running show has no dry run", "leave one of them out")
        with _remote(to, by) as remote:
            answers = remote.edit(parsed)
    else:
        answers = _apply_all(_open(show, dry=dry), parsed, by or "")
    if as_json:
        print(json.dumps(answers, ensure_ascii=False))
    else:
        for number, answer in enumerate(answers, start=1):
            _print_answer(f"edit {number}", answer, dry=dry)
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
    from live.app.services.document_service import edit_date
    from live.document.show_check import ShowCheck

    tables = installed_bridges().patch_tables()
    return DocumentStore(path, tables=tables, check=ShowCheck(path), date=edit_date, dry=dry)


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


def _print_answer(what: str, answer: dict[str, Any], *, dry: bool = False) -> None:
    from live.document.edit import Fault

    if "refused" not in answer:
        print(f"{what}: " + ("would be accepted" if dry else f"revision {answer['revision']}"))
        return
    print(f"{what}: refused")
    for fault in answer["refused"]:
        print(f"  {Fault(**fault)}")


@app.command("log")
def log(show: SHOW, to: TO = None, as_json: JSON = False) -> None:
    """List the revisions of a show: number, date, who, and what they changed; with --to the latest ones."""
    if to is not None:
        with _remote(to, None) as remote:
            rows = remote.log()
        if as_json:
            print(json.dumps(rows, ensure_ascii=False))
            return
        for row in rows:
            print(_log_line(row["revision"], row["date"], row["by"], row["text"]))
        return
    from live.app.bridges import installed_bridges
    from live.app.services.document_service import edit_date
    from live.document.document_store import DocumentStore
    from live.show.patch.patch_search_path import find_patch

    store = DocumentStore(find_patch(show), tables=installed_bridges().patch_tables(), date=edit_date)
    if as_json:
        print(json.dumps([revision.to_json_values() for revision in store.revisions], ensure_ascii=False))
        return
    for revision in store.revisions:
        print(_log_line(revision.number, revision.date, revision.by, revision.text))


def _log_line(number: int, date: str, by: str, text: str) -> str:
    return f"{number:5}  {date:25}  {by or '-':12}  {text}"


@app.command("undo")
def undo(show: SHOW, by: BY = None, to: TO = None, as_json: JSON = False) -> None:
    """Take back the last edit that is in force; with --by the last one of this person."""
    _return(show, by, to, as_json, "undo", lambda store: store.undo(by))


@app.command("redo")
def redo(show: SHOW, by: BY = None, to: TO = None, as_json: JSON = False) -> None:
    """Repeat the edit that was undone last."""
    _return(show, by, to, as_json, "redo", lambda store: store.undo(by, redo=True))


@app.command("restore")
def restore(
    show: SHOW,
    revision: Annotated[int, typer.Argument(help="A number of `live document log`.", min=0)],
    by: BY = None,
    to: TO = None,
    as_json: JSON = False,
) -> None:
    """Return to an earlier revision; what came after it stays in the history."""
    _return(show, by, to, as_json, "restore", lambda store: store.restore(revision, by or ""), revision)


def _return(
    show: str, by: str | None, to: str | None, as_json: bool, what: str,
    action: "Callable[[DocumentStore], Accepted]", *values: int,
) -> None:  # fmt: skip
    from live.document.document_store import refused_json_values
    from live.document.edit import EditRefused

    if to is not None:
        with _remote(to, by) as remote:
            answer = remote.command(what, *values)
    else:
        try:
            answer = action(_open(show)).to_json_values(None)
        except EditRefused as error:
            answer = refused_json_values(None, error)
    if as_json:
        print(json.dumps(answer, ensure_ascii=False))
    else:
        _print_answer(what, answer)
    if "refused" in answer:
        raise typer.Exit(1)


@app.command("keep")
def keep(
    what: Annotated[Literal["measures", "formation", "scene", "cue"], typer.Argument(help="What is kept.")],
    name: Annotated[str, typer.Argument(help="Its name: of the new section, or of what was made live.")],
    to: Annotated[str, typer.Option(help="The show that runs there.", metavar="HOST:PORT")] = "127.0.0.1:9010",
    measures: Annotated[int, typer.Option(help="How many of the last measures become a section.", min=1)] = 16,
    by: BY = None,
    as_json: JSON = False,
) -> None:
    """Keep what a running show made: its last measures as a section, or a formation, scene or cue."""
    with _remote(to, by) as remote:
        values = (measures, name) if what == "measures" else (name,)
        answer = remote.command(f"keep/{what}", *values)
    if as_json:
        print(json.dumps(answer, ensure_ascii=False))
    else:
        _print_answer("keep", answer)
    if "refused" in answer:
        raise typer.Exit(1)


@contextlib.contextmanager
def _remote(to: str, by: str | None) -> "Iterator[RemoteDocument]":
    from live.app.document_remote import RemoteDocument
    from live.app.option_values import parse_endpoint

    remote = RemoteDocument(*parse_endpoint(to, "--to"), by or "")
    try:
        yield remote
    finally:
        remote.close()
