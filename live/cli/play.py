"""`live play`: the show, live; on a machine without a screen its film."""

from pathlib import Path
from typing import Annotated

import typer

PANEL_TIME = "Music and time"
PANEL_PICTURE = "Picture"
PANEL_RECORD = "Recording"
PANEL_ALIVE = "Staying alive"


def play(
    patch: Annotated[
        str | None, typer.Argument(help="A patch (TOML file or folder with show.toml). Default: the first show.")
    ] = None,
    audio: Annotated[
        str | None,
        typer.Option(
            help="An input device to listen to (see `live devices`), or a music file.",
            metavar="DEVICE|FILE",
            rich_help_panel=PANEL_TIME,
        ),
    ] = None,
    audio_channel: Annotated[
        str | None,
        typer.Option(
            help="Which channels of the input: 3, or 5,6, or all. Default: the first two.",
            metavar="N[,N]|all",
            rich_help_panel=PANEL_TIME,
        ),
    ] = None,
    venue: Annotated[
        str | None,
        typer.Option(
            help="The hall: its devices and delays (see `live calibrate`).",
            metavar="NAME",
            rich_help_panel=PANEL_TIME,
        ),
    ] = None,
    bpm: Annotated[
        float | None,
        typer.Option(
            help="The tempo to begin with; without --audio the internal clock keeps it.", rich_help_panel=PANEL_TIME
        ),
    ] = None,
    link: Annotated[
        str | None,
        typer.Option(
            help="Ableton Link: follow others' tempo and beat, or lead them with the show's. Default: the patch's.",
            metavar="follow|lead|off",
            rich_help_panel=PANEL_TIME,
        ),
    ] = None,
    midi: Annotated[
        str | None,
        typer.Option(
            help="A MIDI port to listen to (see `live devices`): clock, time code, pedals and keys; or off.",
            metavar="NAME",
            rich_help_panel=PANEL_TIME,
        ),
    ] = None,
    midi_clock_out: Annotated[
        str | None,
        typer.Option(
            help="A MIDI port that the show's beat is sent to as MIDI clock; or off.",
            metavar="NAME",
            rich_help_panel=PANEL_TIME,
        ),
    ] = None,
    click: Annotated[
        str | None,
        typer.Option(
            help="An output on which the players hear a click (see `live devices`).",
            metavar="DEVICE",
            rich_help_panel=PANEL_TIME,
        ),
    ] = None,
    click_channels: Annotated[
        str | None,
        typer.Option(help="Which channels of it, from 1: 3, or 5,6.", metavar="N", rich_help_panel=PANEL_TIME),
    ] = None,
    seconds: Annotated[
        float | None, typer.Option(help="End after so many seconds.", rich_help_panel=PANEL_TIME)
    ] = None,
    measures: Annotated[
        str | None,
        typer.Option(
            help="Practise these measures of the score, again and again, without the patch's music.",
            metavar="17-24",
            rich_help_panel=PANEL_TIME,
        ),
    ] = None,
    tempo_share: Annotated[
        float | None,
        typer.Option(
            help="Practise at this share of the tempo: 0.8 is slower.", metavar="0.1-2", rich_help_panel=PANEL_TIME
        ),
    ] = None,
    steps: Annotated[
        Path | None,
        typer.Option(
            help="Dance the recordings of this folder (BVH files and TOML) instead of the patch's steps.",
            file_okay=False,
        ),
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, max=2**31 - 1, help="Seed of all chance in the show.")] = None,
    osc: Annotated[str, typer.Option(help="Where OSC is received.", metavar="HOST:PORT")] = "127.0.0.1:9010",
    monitor: Annotated[
        str | None,
        typer.Option(
            help='Monitor by number, name or place ("right of primary").',
            metavar="N|NAME",
            rich_help_panel=PANEL_PICTURE,
        ),
    ] = None,
    fullscreen: Annotated[
        bool, typer.Option("--fullscreen", help="Full screen.", rich_help_panel=PANEL_PICTURE)
    ] = False,
    operator: Annotated[
        str | None,
        typer.Option(
            help="A window of the operator's own on this monitor: the picture with overlay and guides, which "
            "no projector shows then.",
            metavar="N|NAME",
            rich_help_panel=PANEL_PICTURE,
        ),
    ] = None,
    headless: Annotated[
        bool,
        typer.Option(
            "--headless",
            help="No window: run in real time without a picture, or --record or --share it.",
            rich_help_panel=PANEL_PICTURE,
        ),
    ] = False,
    size: Annotated[
        str, typer.Option(help="Size of the window or film.", metavar="WxH", rich_help_panel=PANEL_PICTURE)
    ] = "1280x720",
    fps: Annotated[
        float | None,
        typer.Option(help="Default: the monitor's; 30 without a graphics card.", rich_help_panel=PANEL_PICTURE),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(help="Record the picture as an mp4.", metavar="FILE.mp4", rich_help_panel=PANEL_RECORD),
    ] = None,
    share: Annotated[
        list[str] | None,
        typer.Option(
            help="Share the picture with other programs: shm:NAME, or a stream like udp://127.0.0.1:5000.",
            metavar="shm:NAME|URL",
            rich_help_panel=PANEL_RECORD,
        ),
    ] = None,
    journal: Annotated[
        Path | None, typer.Option(help="Write the journal here, for `live replay`.", rich_help_panel=PANEL_RECORD)
    ] = None,
    status_json: Annotated[
        Path | None, typer.Option(help="Write one JSON line of figures a second.", rich_help_panel=PANEL_RECORD)
    ] = None,
    alone: Annotated[
        bool,
        typer.Option(
            "--alone",
            help="One process only: nobody watches over the show and takes over when it ends in a crash.",
            rich_help_panel=PANEL_ALIVE,
        ),
    ] = False,
    lead: Annotated[
        str | None,
        typer.Option(
            help="Let machines that stand by follow this show here.", metavar="[HOST:]PORT", rich_help_panel=PANEL_ALIVE
        ),
    ] = None,
    standby: Annotated[
        str | None,
        typer.Option(
            help="Follow the show of the machine that leads there, and take over when it falls silent.",
            metavar="HOST[:PORT]",
            rich_help_panel=PANEL_ALIVE,
        ),
    ] = None,
) -> None:
    """Play a show: music in, dancers on the projector.

    Keys: Space tap, 1 this is the one, B blackout, F full screen, O overlay, S spread; click or drag = attractor,
    with shift = repulsor. Closing the window, Esc in a window or Ctrl-C here ends the show; music from a file begins
    again at its end. Without a screen, 20 s of the show become a film, first-show.mp4.
    """
    from rich.console import Console

    from live.cli.options import (
        film_file,
        parse_choice,
        parse_endpoint,
        parse_measures,
        parse_number,
        parse_size,
        writable_file,
    )
    from live.cli.played import Played
    from live.cli.share_names import parse_shares
    from live.cli.supervised import is_supervised, supervise
    from live.cli.warm import warm_kernels
    from live.cli.wish import Wish

    parse_number(bpm, "--bpm", 20, 400)
    parse_number(seconds, "--seconds", 0.1, 7 * 86400)
    parse_number(fps, "--fps", 1, 480)
    parse_number(tempo_share, "--tempo-share", 0.1, 2.0)
    for path, name in ((record, "--record"), (journal, "--journal"), (status_json, "--status-json")):
        writable_file(path, name)
    film_file(record, "--record", never=[audio, patch])
    played = Played(
        Wish(
            patch=patch,
            audio=audio,
            audio_channel=audio_channel,
            venue=venue,
            bpm=bpm,
            click=click,
            click_channels=click_channels,
            link=parse_choice(link, "--link", "follow", "lead", "off"),
            midi=midi,
            midi_clock_out=midi_clock_out,
            steps=steps,
            seed=seed,
            measures=parse_measures(measures),
            tempo_share=tempo_share,
            osc=parse_endpoint(osc),
            journal=journal,
            status_json=status_json,
            seconds=seconds,
            record=record,
            share=parse_shares(share),
            operator=operator,
            size=parse_size(size),
            fps=fps,
        ),
        monitor=monitor,
        fullscreen=fullscreen,
        headless=headless,
    )
    if is_supervised(played, alone=alone, machines=lead is not None or standby is not None):
        supervise(played, lead=lead, standby=standby)
        return
    warm_kernels(Console(stderr=True, highlight=False))  # before anything is imported that has kernels
    from live.cli.stage import play_show

    play_show(played.wish, monitor=monitor, fullscreen=fullscreen, headless=headless)
