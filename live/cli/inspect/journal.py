"""Commands `live journal show | diff | export`: print, compare and convert journals."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from live.show.journal.journal_reader import Journal, Survey


app = typer.Typer(help="Read journals of shows: print, compare, or convert to MIDI or CSV.", no_args_is_help=True)
FILE = Annotated[Path, typer.Argument(help="A journal written by --journal.")]


@app.command("show")
def show(
    journal: FILE,
    picture: Annotated[Path | None, typer.Option(help="Draw the timeline.", metavar="OUT.svg|OUT.png")] = None,
    events: Annotated[bool, typer.Option("--events", help="List every event as well.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False,
) -> None:
    """Print duration, number of measures, events by source, and damaged lines."""

    from rich.console import Console

    from live.app.offline.journal_report import journal_facts, read_journal_file
    from live.app.pictures.journal_picture import draw_journal, size_of
    from live.app.pictures.reach_picture import PngCanvas, SvgCanvas
    from live.base.errors import PersonError
    from live.library.whole_file import write_atomically
    from live.show.journal.journal_reader import survey

    if picture is not None and picture.suffix.lower() not in (".svg", ".png"):
        raise PersonError(f"--picture {picture}: a name that ends in .svg or .png expected")
    recorded = read_journal_file(journal)
    found = survey(recorded)
    if picture is not None:
        size = size_of(found)
        canvas = SvgCanvas(size) if picture.suffix.lower() == ".svg" else PngCanvas(size)
        draw_journal(found, canvas)
        write_atomically(canvas.data(), picture, "--picture")
    if as_json:
        print(json.dumps(journal_facts(found)))
        return
    console = Console(highlight=False)
    if events:
        _print_events(recorded, console)
    _print_survey(found, console)


def _print_survey(found: "Survey", console: Any) -> None:
    from rich.table import Table

    from live.app.offline.journal_report import journal_facts

    facts = journal_facts(found)
    end = "" if facts["complete"] else " (cut off)"
    tempo = "" if facts["bpm"] is None else ", {:.1f} to {:.1f} bpm".format(*facts["bpm"])
    console.print(
        f"{facts['show']}, seed {facts['seed']}, format {facts['format']} of version {facts['version']}: "
        f"{facts['seconds'] / 60:.1f} min{end}, {facts['measures']} measures{tempo}",
        markup=False,
    )
    kept = facts["snapshots"]
    console.print(
        f"{facts['bytes'] / 1e6:.2f} MB, {len(kept['measures'])} snapshots in {kept['bytes'] / 1e6:.2f} MB; "
        f"{facts['skipped_ticks']} ticks skipped in stalls"
    )
    table = Table("source", "event", "count")
    for row in facts["events"]:
        table.add_row(row["source"], row["type"], str(row["count"]))
    console.print(table)
    for problem in facts["problems"][:20]:
        console.print(problem, style="yellow", markup=False, soft_wrap=True)
    if len(facts["problems"]) > 20:
        console.print(f"and {found.damaged - 20} more damaged lines", style="yellow")


def _print_events(journal: "Journal", console: Any) -> None:

    from live.clock.ticks import TICK
    from live.control.events.event_json import event_to_json

    measure = 1
    for line in journal.lines_with_damage():
        if line.measure is not None:
            measure = line.measure
        if line.event is None:
            continue
        values = event_to_json(line.event)
        kind, source = values.pop("type"), values.pop("source")
        del values["time"]
        told = " ".join(f"{key}={value}" for key, value in values.items())
        console.print(
            f"{line.tick * TICK:9.2f} s  m{measure:<5} {source:10} {kind} {told}", markup=False, soft_wrap=True
        )


@app.command("diff")
def diff(
    first: FILE,
    second: Annotated[Path, typer.Argument(help="Another journal.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Print the first event and the first state that differ between two journals. Exit 1 if there are any."""

    from rich.console import Console

    from live.app.offline.journal_report import read_journal_file
    from live.show.journal.journal_diff import differences

    found = differences(read_journal_file(first), read_journal_file(second))
    if as_json:
        facts = {
            "header": list(found.header),
            "event": None if found.event is None else found.event.as_json(),
            "state": None if found.state is None else found.state.as_json(),
            "events": list(found.events),
            "measures": list(found.measures),
        }
        print(json.dumps(facts))
    else:
        console = Console(highlight=False, soft_wrap=True)
        if found.equal:
            console.print(f"the same show: {found.events[0]} events, {found.measures[0]} measures")
        if found.header:
            console.print(f"different headers: {', '.join(found.header)}", markup=False)
        if found.event is not None:
            console.print(f"first different event ({found.events[0]} | {found.events[1]} in all):")
            console.print(f"  {found.event.in_words()}", markup=False)
        if found.state is not None:
            console.print(f"first different state ({found.measures[0]} | {found.measures[1]} measures):")
            console.print(f"  {found.state.in_words()}", markup=False)
    if not found.equal:
        raise typer.Exit(1)


@app.command("export")
def export(
    journal: FILE,
    out: Annotated[
        Path, typer.Argument(help="A MIDI file (beats, markers, steps) or a table.", metavar="OUT.mid|OUT.csv")
    ],
) -> None:
    """Export as a MIDI file (which replays the show), or as a table with a row for each event and measure."""
    from rich.console import Console

    from live.app.offline.journal_report import read_journal_file, write_table
    from live.app.option_values import check_writable
    from live.base.errors import PersonError
    from live.library.whole_file import write_atomically

    kind = out.suffix.lower()
    if kind not in (".mid", ".midi", ".csv"):
        raise PersonError(f"{out}: a name that ends in .mid or .csv expected", f"{out.stem}.mid")
    check_writable(out, "OUT")
    recorded = read_journal_file(journal)
    if kind == ".csv":
        write_table(recorded, out)
        return
    from live.app.machine.kernel_warmup import warm_kernels
    from live.app.offline.journal_midi import journal_to_midi
    from live.show.journal.replay import ReplayError, first_start, load_journal

    warm_kernels(Console(stderr=True))
    try:
        start = first_start(recorded, load_journal(recorded))
    except ReplayError as error:
        raise PersonError(str(error)) from None
    write_atomically(journal_to_midi(recorded, start), out, "OUT")
