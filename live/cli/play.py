"""`live play`: the show, live; on a machine without a screen its film.

Options of `live play` for who watches over it, and takes over when it ends.

Options of `live play` for music and time: what the show hears, and which clock it follows.

Options of `live play` for its picture: where it is shown, and how it is drawn.

Options of `live play` for programs, machines and people that play along over the network.

Options of `live play` for what is kept of it, or given to others: film, picture, journal, figures.
"""

from pathlib import Path
from typing import Annotated

import typer

ALIVE_PANEL = "Staying alive"

Alone = Annotated[
    bool,
    typer.Option(
        "--alone",
        help="One process only: nobody watches over the show and takes over when it ends in a crash.",
        rich_help_panel=ALIVE_PANEL,
    ),
]
Lead = Annotated[
    str | None,
    typer.Option(
        help="Let machines that stand by follow this show here.", metavar="[HOST:]PORT", rich_help_panel=ALIVE_PANEL
    ),
]
Service = Annotated[
    str | None,
    typer.Option(
        help="Which service this is (`live service install` writes it): a start goes on with what was cut off.",
        metavar="NAME",
        rich_help_panel=ALIVE_PANEL,
    ),
]
Standby = Annotated[
    str | None,
    typer.Option(
        help="Follow the show of the machine that leads there, and take over when it falls silent.",
        metavar="HOST[:PORT]",
        rich_help_panel=ALIVE_PANEL,
    ),
]


MUSIC_PANEL = "Music and time"

Audio = Annotated[
    str | None,
    typer.Option(
        help="An input device to listen to (see `live devices`), or a music file.",
        metavar="DEVICE|FILE",
        rich_help_panel=MUSIC_PANEL,
    ),
]
AudioChannel = Annotated[
    str | None,
    typer.Option(
        help="Which channels of the input: 3, or 5,6, or all. Default: the first two.",
        metavar="N[,N]|all",
        rich_help_panel=MUSIC_PANEL,
    ),
]
Venue = Annotated[
    str | None,
    typer.Option(
        help="The hall: its devices and delays (see `live calibrate`).",
        metavar="NAME",
        rich_help_panel=MUSIC_PANEL,
    ),
]
Bpm = Annotated[
    float | None,
    typer.Option(
        help="The tempo to begin with; without --audio the internal clock keeps it.", rich_help_panel=MUSIC_PANEL
    ),
]
Link = Annotated[
    str | None,
    typer.Option(
        help="Ableton Link: follow others' tempo and beat, or lead them with the show's. Default: the patch's.",
        metavar="follow|lead|off",
        rich_help_panel=MUSIC_PANEL,
    ),
]
Midi = Annotated[
    str | None,
    typer.Option(
        help="A MIDI port to listen to (see `live devices`): clock, time code, pedals and keys; tcp:HOST:PORT, "
        "rtp:HOST:PORT, raw:PATH; or off.",
        metavar="NAME",
        rich_help_panel=MUSIC_PANEL,
    ),
]
MidiFile = Annotated[
    Path | None,
    typer.Option(
        help="A MIDI file: its tempo map leads the beat, its notes move the dance and work what the map says.",
        metavar="FILE.mid",
        rich_help_panel=MUSIC_PANEL,
    ),
]
MidiOut = Annotated[
    str | None,
    typer.Option(
        help="A MIDI port that is told present values, for lights of pads and motor faders; or off.",
        metavar="NAME",
        rich_help_panel=MUSIC_PANEL,
    ),
]
MidiClockOut = Annotated[
    str | None,
    typer.Option(
        help="A MIDI port that the show's beat is sent to as MIDI clock; or off.",
        metavar="NAME",
        rich_help_panel=MUSIC_PANEL,
    ),
]
Click = Annotated[
    str | None,
    typer.Option(
        help="An output on which the players hear a click (see `live devices`).",
        metavar="DEVICE",
        rich_help_panel=MUSIC_PANEL,
    ),
]
ClickChannels = Annotated[
    str | None,
    typer.Option(help="Which channels of it, from 1: 3, or 5,6.", metavar="N", rich_help_panel=MUSIC_PANEL),
]
Seconds = Annotated[float | None, typer.Option(help="End after so many seconds.", rich_help_panel=MUSIC_PANEL)]
Measures = Annotated[
    str | None,
    typer.Option(
        help="Practise these measures of the score, again and again, without the patch's music.",
        metavar="17-24",
        rich_help_panel=MUSIC_PANEL,
    ),
]
TempoShare = Annotated[
    float | None,
    typer.Option(
        help="Practise at this share of the tempo: 0.8 is slower.", metavar="0.1-2", rich_help_panel=MUSIC_PANEL
    ),
]


PICTURE_PANEL = "Picture"

Monitor = Annotated[
    str | None,
    typer.Option(
        help='Monitor by number, name or place ("right of primary").',
        metavar="N|NAME",
        rich_help_panel=PICTURE_PANEL,
    ),
]
Fullscreen = Annotated[bool, typer.Option("--fullscreen", help="Full screen.", rich_help_panel=PICTURE_PANEL)]
Operator = Annotated[
    str | None,
    typer.Option(
        help="A window of the operator's own on this monitor: the picture with overlay and guides, which "
        "no projector shows then.",
        metavar="N|NAME",
        rich_help_panel=PICTURE_PANEL,
    ),
]
Headless = Annotated[
    bool,
    typer.Option(
        "--headless",
        help="No window: run in real time without a picture, or --record or --share it.",
        rich_help_panel=PICTURE_PANEL,
    ),
]
Size = Annotated[str, typer.Option(help="Size of the window or film.", metavar="WxH", rich_help_panel=PICTURE_PANEL)]
Fps = Annotated[
    float | None,
    typer.Option(help="Default: the monitor's; 30 without a graphics card.", rich_help_panel=PICTURE_PANEL),
]
Shaders = Annotated[
    Path | None,
    typer.Option(
        help="For who works on looks: draw with the shaders of this folder, and anew whenever one is edited. "
        "A folder that is not there is made, with copies of the program's own.",
        file_okay=False,
        metavar="FOLDER",
        rich_help_panel=PICTURE_PANEL,
    ),
]
Quality = Annotated[
    int | None,
    typer.Option(
        help="Hold a step of quality, 0 is the best. Default: as the machine can afford.",
        rich_help_panel=PICTURE_PANEL,
    ),
]


Osc = Annotated[str, typer.Option(help="Where OSC is received.", metavar="HOST:PORT")]
OscProcess = Annotated[
    bool | None,
    typer.Option(
        "--osc-process/--no-osc-process",
        help="Receive OSC in a process of its own, so that floods cost the picture little, or in the show's. Without "
        "either: of its own, but where the whole show is one process.",
    ),
]
OscMusicians = Annotated[
    str | None,
    typer.Option(
        help="A port of their own for musicians: what only an operator may is refused there.",
        metavar="HOST:PORT",
    ),
]
OscOut = Annotated[
    list[str] | None,
    typer.Option(
        help="Tell programs there over OSC what happens: beat, tempo, steps, feet, places. May come several times.",
        metavar="HOST:PORT",
    ),
]
Dmx = Annotated[
    list[str] | None,
    typer.Option(
        help="Let the hall's lamps follow the show: channels as [[dmx]] says. May come several times.",
        metavar="sacn:UNIVERSE[@HOST]|artnet:UNIVERSE@HOST",
    ),
]
Web = Annotated[
    str | None,
    typer.Option(
        help="Serve the operator's page for a browser: all controls, the values of now. Only the link that is "
        "printed lets in: it has the key.",
        metavar="[HOST:]PORT",
    ),
]
WebKey = Annotated[
    str | None,
    typer.Option(
        help="A key of your own for that page (16 characters or more), instead of the one that is kept. Others on this "
        "machine can read a command line: the variable is better.",
        metavar="KEY",
        envvar="LIVE_WEB_KEY",
    ),
]
NewWebKey = Annotated[
    bool,
    typer.Option("--new-web-key", help="Make another key for that page: who had the old one is let in no more."),
]
WebHost = Annotated[
    list[str] | None,
    typer.Option(
        help="A name by which this machine is reached beside its addresses, for that page and OSCQuery. May come "
        "several times.",
        metavar="NAME[:PORT]",
    ),
]
Psn = Annotated[
    str | None,
    typer.Option(
        help="Listen there for trackers by PosiStageNet, usually 236.10.10.10:56565; ADDRESS: of the network card.",
        metavar="[GROUP:]PORT[@ADDRESS]",
    ),
]
VmcOut = Annotated[
    list[str] | None,
    typer.Option(
        help="Send dancers to other programs as avatars by the VMC protocol: the first, or whom WHO means, each to "
        "the next port. May come several times.",
        metavar="HOST:PORT[=WHO][@RATE]",
    ),
]
Vmc = Annotated[
    list[str] | None,
    typer.Option(
        help="Listen there for a real dancer's body by the VMC protocol (usually 39539). May come several times.",
        metavar="[HOST:]PORT|HOST",
    ),
]
Oscquery = Annotated[
    str | None,
    typer.Option(
        help="Be found by ossia score, Chataigne, TouchOSC and others: OSCQuery over HTTP, and zeroconf.",
        metavar="HOST:PORT",
    ),
]
Audience = Annotated[
    str | None,
    typer.Option(
        help="Let the audience's phones play along, here: 127.0.0.1:8020 if nothing else is said; "
        "0.0.0.0:8020 lets in the whole network.",
        metavar="[[HOST:]PORT]",
    ),
]
AudienceLink = Annotated[
    str | None,
    typer.Option(help="The address that phones are given, if it is another one.", metavar="http://HOST[:PORT]"),
]
AudienceTls = Annotated[
    str | None,
    typer.Option(
        help="Meet phones over https, with this certificate and its key (PEM files, as Let's Encrypt makes them).",
        metavar="CERT,KEY",
    ),
]


RECORDING_PANEL = "Recording"

Record = Annotated[
    Path | None,
    typer.Option(help="Record the picture as an mp4.", metavar="FILE.mp4", rich_help_panel=RECORDING_PANEL),
]
Share = Annotated[
    list[str] | None,
    typer.Option(
        help="Share the picture with other programs: shm:NAME, or a stream like udp://127.0.0.1:5000.",
        metavar="shm:NAME|URL",
        rich_help_panel=RECORDING_PANEL,
    ),
]
Journal = Annotated[
    Path | None, typer.Option(help="Write the journal here, for `live replay`.", rich_help_panel=RECORDING_PANEL)
]
StatusJson = Annotated[
    Path | None, typer.Option(help="Write one JSON line of figures a second.", rich_help_panel=RECORDING_PANEL)
]


def play(
    patch: Annotated[
        str | None, typer.Argument(help="A patch (TOML file or folder with show.toml). Default: the first show.")
    ] = None,
    audio: Audio = None,
    audio_channel: AudioChannel = None,
    venue: Venue = None,
    bpm: Bpm = None,
    link: Link = None,
    midi: Midi = None,
    midi_file: MidiFile = None,
    midi_out: MidiOut = None,
    midi_clock_out: MidiClockOut = None,
    click: Click = None,
    click_channels: ClickChannels = None,
    seconds: Seconds = None,
    measures: Measures = None,
    tempo_share: TempoShare = None,
    steps: Annotated[
        Path | None,
        typer.Option(
            help="Dance the recordings of this folder (BVH files and TOML) instead of the patch's steps.",
            file_okay=False,
        ),
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, max=2**31 - 1, help="Seed of all chance in the show.")] = None,
    osc: Osc = "127.0.0.1:9010",
    osc_process: OscProcess = None,
    osc_musicians: OscMusicians = None,
    osc_out: OscOut = None,
    dmx: Dmx = None,
    web: Web = None,
    web_key: WebKey = None,
    new_web_key: NewWebKey = False,
    web_host: WebHost = None,
    psn: Psn = None,
    vmc_out: VmcOut = None,
    vmc: Vmc = None,
    oscquery: Oscquery = None,
    audience: Audience = None,
    audience_link: AudienceLink = None,
    audience_tls: AudienceTls = None,
    monitor: Monitor = None,
    fullscreen: Fullscreen = False,
    operator: Operator = None,
    headless: Headless = False,
    size: Size = "1280x720",
    fps: Fps = None,
    shaders: Shaders = None,
    quality: Quality = None,
    record: Record = None,
    share: Share = None,
    journal: Journal = None,
    status_json: StatusJson = None,
    alone: Alone = False,
    lead: Lead = None,
    standby: Standby = None,
    service: Service = None,
) -> None:
    """Play a show: music in, dancers on the projector.

    Keys: Space tap, 1 this is the one, B blackout, F full screen, O overlay, S spread; click or drag = attractor,
    with shift = repulsor. Closing the window, Esc in a window or Ctrl-C here ends the show; music from a file begins
    again at its end. Without a screen, 20 s of the show become a film, first-show.mp4.
    """
    import secrets
    from dataclasses import replace

    from rich.console import Console

    from live.app.kernel_warmup import warm_kernels
    from live.app.launch_options import Played, Wish
    from live.app.live_recording import parse_shares
    from live.app.option_values import (
        audience_address,
        audience_web_address,
        film_file,
        parse_choice,
        parse_endpoint,
        parse_measures,
        parse_number,
        parse_size,
        with_port,
        writable_file,
    )
    from live.app.processes.engine_main import is_supervised, supervise
    from live.app.services.audience_tls import parse_tls
    from live.app.services.http_services import parse_web
    from live.show.patch.patch_search_path import find_patch

    parse_number(bpm, "--bpm", 20, 400)
    parse_number(seconds, "--seconds", 0.1, 7 * 86400)
    parse_number(fps, "--fps", 1, 480)
    parse_number(quality, "--quality", 0, 15)
    parse_number(tempo_share, "--tempo-share", 0.1, 2.0)
    for path, name in ((record, "--record"), (journal, "--journal"), (status_json, "--status-json")):
        writable_file(path, name)
    film_file(record, "--record", never=[audio, patch])
    find_patch(patch)  # a name that nobody knows is told before seconds of loading
    console = Console(stderr=True, highlight=False)
    page = parse_web(
        web, key=web_key, new_key=new_web_key, hosts=web_host or (),
        note=lambda words: console.print(f"note: {words}", style="yellow", markup=False, soft_wrap=True),
    )  # fmt: skip
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
            midi_file=midi_file,
            midi_out=midi_out,
            midi_clock_out=midi_clock_out,
            steps=steps,
            seed=seed,
            measures=parse_measures(measures),
            tempo_share=tempo_share,
            osc=parse_endpoint(osc),
            osc_process=bool(osc_process),
            osc_musicians=None if osc_musicians is None else parse_endpoint(osc_musicians, "--osc-musicians"),
            osc_out=tuple(parse_endpoint(each, "--osc-out") for each in osc_out or ()),
            dmx=tuple(dmx or ()),
            psn=psn,
            vmc_out=tuple(vmc_out or ()),
            vmc=tuple(parse_endpoint(with_port(each, 39539), "--vmc") for each in vmc or ()),
            oscquery=None if oscquery is None else parse_endpoint(oscquery, "--oscquery"),
            web=page.where,
            web_key=page.key,
            web_hosts=page.hosts,
            audience=None if audience is None else audience_address(audience),
            audience_link=audience_web_address(audience_link),
            audience_tls=parse_tls(audience_tls),
            audience_secret=b"" if audience is None else secrets.token_bytes(32),
            journal=journal,
            status_json=status_json,
            seconds=seconds,
            record=record,
            share=parse_shares(share),
            operator=operator,
            size=parse_size(size),
            fps=fps,
            shaders=shaders,
            quality=quality,
        ),
        monitor=monitor,
        fullscreen=fullscreen,
        headless=headless,
    )
    if is_supervised(played, alone=alone, machines=lead is not None or standby is not None):
        if osc_process is None:
            played = replace(played, wish=replace(played.wish, osc_process=True))
        supervise(played, lead=lead, standby=standby, service=service)
        return
    warm_kernels(console)  # before anything is imported that has kernels
    from live.app.headless_loop import play_show

    play_show(played.wish, monitor=monitor, fullscreen=fullscreen, headless=headless)
