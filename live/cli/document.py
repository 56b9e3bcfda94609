"""Commands `live document …`: edits of a show's files, their history, and a preview of any measures."""

import contextlib
import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from live.base.system.process_control import yield_priority

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

    parsed = parse_edits(_read_edits(edits), "the standard input" if edits == "-" else edits)
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


def _read_edits(name: str) -> str:
    from live.base.errors import PersonError

    try:
        return sys.stdin.read() if name == "-" else Path(name).read_text("utf-8")
    except (OSError, ValueError) as error:
        raise PersonError(f"cannot read the edits {name}: {error}") from None


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
        later = f", from the next start on: {', '.join(answer['waits'])}" if answer.get("waits") else ""
        print(f"{what}: " + ("would be accepted" if dry else f"revision {answer['revision']}{later}"))
        for note in answer.get("notes", ()):
            print(f"  {Fault(**note)}")
        more = answer.get("note_count", 0) - len(answer.get("notes", ()))
        if more > 0:
            print(f"  ... and {more} more; `live check` lists them")
        return
    print(f"{what}: refused")
    for fault in answer["refused"]:
        print(f"  {Fault(**fault)}")


@app.command("preview")
def preview(
    show: SHOW,
    first: Annotated[int, typer.Option("--from", help="The first measure, from 1.", min=1)] = 1,
    last: Annotated[int | None, typer.Option("--to", help="The last measure; left out: the first one.", min=1)] = None,
    edits: Annotated[
        str | None, typer.Option("--with", help="Edits that are tried and not saved.", metavar="EDITS.json")
    ] = None,
    as_json: JSON = False,
) -> None:
    """Simulate measures of a show aside: where everybody stands, their ways, who would meet, which way is too long.

    Without sound and picture, at low priority. Exit 1 if an edit was refused.
    """
    from dataclasses import replace

    from live.app.launch_options import LaunchOptions
    from live.document.edit import parse_edits

    yield_priority(15)
    parsed = [] if edits is None else parse_edits(_read_edits(edits), edits)
    store = _open(show, dry=True)
    answers = _apply_all(store, parsed, "")
    from live.document.preview import PreviewEngine, preview_values
    from live.show.score.division_tree import tree_lines

    engine = PreviewEngine(replace(LaunchOptions(patch=show).load(), patch=store.document.patch))
    values = preview_values(engine, first, last or first)
    if as_json:
        print(json.dumps({**values, "answers": answers}, ensure_ascii=False))
    else:
        for number, answer in enumerate(answers, start=1):
            _print_answer(f"edit {number}", answer, dry=True)
        _print_preview(values)
        for line in tree_lines(engine.division(first, last or first)):
            print(line)
    if any("refused" in answer for answer in answers):
        raise typer.Exit(1)


def _print_preview(values: dict[str, Any]) -> None:
    for measure in values["measures"]:
        print(f"measure {measure['measure']}, {measure['time_s']:.2f} s")
        for number, dancer in enumerate(measure["dancers"], start=1):
            if dancer is not None:
                print(f"  {number:4}  {dancer[0]:7.2f} {dancer[1]:7.2f}  {dancer[3]}")
    for one in values["meetings"]:
        print(
            "measure {}: dancers {} and {} would come as near as {} m".format(
                one["measure"], *one["dancers"], one["distance"]
            )
        )
    for one in values["too_far"]:
        far = f"{one['distance']} m to go, and reaches {one['reach']} m"
        print(f"measure {one['measure']}: dancer {one['dancer']} has {far}")
    for note in values["notes"]:
        print(f"note: {note}")


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


@app.command("music")
def music(
    show: SHOW,
    file: Annotated[str, typer.Argument(help="The music: a file in the show's folder.")],
    lines: Annotated[
        str | None,
        typer.Option(help="Its measure lines, a file in the show's folder. Left out: as the tracker proposes them."),
    ] = None,
    fix: Annotated[
        Path | None, typer.Option(help="Corrections of the proposal, as a JSON list (`live docs measures`).")
    ] = None,
    by: BY = None,
    to: TO = None,
    as_json: JSON = False,
) -> None:
    """Replace the music of a show and its measures, as one revision. The score keeps its measures; what no longer fits
    is named at its place."""
    from live.base.errors import PersonError

    if to is not None:
        if fix is not None:
            raise PersonError("--fix with --to: a running show proposes by itself", "give --lines (live music map)")
        with _remote(to, by) as remote:
            answer = remote.command("music", file, lines or "", timeout=REMOTE_MUSIC_TIMEOUT)
    else:
        answer = _replace_music(show, file, lines, fix, by or "")
    if as_json:
        print(json.dumps(answer, ensure_ascii=False))
    else:
        _print_answer("music", answer)
    if "refused" in answer:
        raise typer.Exit(1)


REMOTE_MUSIC_TIMEOUT = 600.0
"""Longest wait for a running show to hear the music [s]."""


def _replace_music(show: str, file: str, lines: str | None, fix: Path | None, by: str) -> dict[str, Any]:
    from live.app.offline.music_map import read_fixes, read_measures
    from live.base.errors import PersonError
    from live.document.document_store import refused_json_values
    from live.document.edit import EditRefused
    from live.document.music_edits import replace_music
    from live.show.patch.patch_search_path import find_patch, find_resource

    path = find_patch(show)
    found = {name: find_resource(name, path) for name in (file, lines) if name is not None}
    for name, where in found.items():
        if where is None:
            raise PersonError(f"there is no file {name!r} in {path.parent}", "put it next to the patch")
    sound = found[file]
    assert sound is not None
    measures = read_measures(sound, [] if fix is None else read_fixes(fix), None if lines is None else found[lines])
    try:
        return replace_music(_open(show), file, measures, by).to_json_values(None)
    except EditRefused as error:
        return refused_json_values(None, error)


@app.command("keep")
def keep(
    what: Annotated[Literal["measures", "ways", "formation", "scene", "cue"], typer.Argument(help="What is kept.")],
    name: Annotated[str, typer.Argument(help="Its name: of the new section, or of what was made live.")],
    to: Annotated[str, typer.Option(help="The show that runs there.", metavar="HOST:PORT")] = "127.0.0.1:9010",
    measures: Annotated[int, typer.Option(help="How many of the last measures become a section, or ways.", min=1)] = 16,
    by: BY = None,
    as_json: JSON = False,
) -> None:
    """Keep what a running show made: its last measures as a section, dancers' ways, a formation, scene or cue."""
    with _remote(to, by) as remote:
        values = (measures, name) if what in ("measures", "ways") else (name,)
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
