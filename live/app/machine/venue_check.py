"""Checks of `live check SHOW --venue V`: the show, its score, and the hall's devices."""

import shutil
import socket
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from live.app.machine.device_list import Section, audio_sections, midi_sections
from live.app.machine.machine_check import Check, check_kernels, check_monitors, check_opengl
from live.base.errors import PersonError
from live.show.loader import LoadedShow
from live.show.show import Show
from live.show.venue.venue import Venue

if TYPE_CHECKING:
    from live.render.outputs.output import Output


OSC_TIMEOUT_S = 2.0
"""Time-out of the OSC test packet [s]."""
MIN_FREE_MB = (300.0, 2000.0)
"""Minimum free disk space [MB] for the journal of one evening, and for a film."""


def show_checks(loaded: LoadedShow, show: Show) -> Iterator[Check]:
    """Yield checks of the transitions between steps, and warnings about the score."""
    from live.rehearse.lint import lint_show

    graph = loaded.graph
    if graph.missing:
        for words in graph.missing:
            yield Check("steps", "missing", words, "record it, or raise locomotion.threshold_m", needed=True)
    else:
        yield Check("steps", "ok", f"{len(graph.library.steps)} steps, {graph.edge_count} transitions", needed=True)
    for doubts in lint_show(show):
        if not doubts.warnings:
            yield Check(doubts.name, "ok", doubts.count_text)
        for words in doubts.warnings:
            yield Check(doubts.name, "limited", words, doubts.remedy)


def output_checks(venue: Venue, name: str | None) -> Iterator[Check]:
    """Yield checks of a venue's projectors: their monitors and masks."""
    from live.app.output_config import outputs_of

    if venue.operator is not None:
        yield _run_check("operator", partial(_monitor, venue.operator, "the operator window"), "plug it in")
    for output in outputs_of(venue, name) if venue.output else ():
        what = f"output {output.name}"
        if output.monitor is not None:
            yield _run_check(what, partial(_monitor, output.monitor, "its monitor"), "plug it in")
        if output.mask is not None:
            yield _run_check(f"{what} mask", partial(_mask, output), "save it as PNG")


def part_checks(loaded: LoadedShow, venue: Venue | None) -> Iterator[Check]:
    """Yield a check whether each machine of the venue can draw its part of the picture alone."""
    from live.base.picture_parameters import picture_row
    from live.render.outputs.picture_layout import WORTH, shown_share, whole_picture_reason

    machines: dict[str, list[Output]] = {}
    for one in () if venue is None else venue.output:
        machines.setdefault(one.node or "this machine", []).append(one.output(Path()))
    partly = [name for name, outputs in machines.items() if shown_share(outputs) <= WORTH]
    if not partly:
        return
    scene = loaded.scene(whole=False)
    reason = whole_picture_reason(scene, picture_row(scene))
    if reason:
        remedy = "without it each machine draws only what its outputs show"
        yield Check("picture", "limited", f"{', '.join(partly)}: all of it is drawn: {reason}", remedy)
        return
    yield Check("picture", "ok", f"{', '.join(partly)}: only what the outputs show is drawn, with a border")
    if venue is not None and venue.picture_size is None and len(machines) > 1:
        remedy = "write picture_size = [width, height] in the venue's file, so that all machines draw the same picture"
        yield Check("picture_size", "limited", "each machine takes the size that its own windows need", remedy)


def _monitor(name: str, where: str) -> str:
    from live.app.output_config import configured_monitor

    return str(configured_monitor(name, where))


def _mask(output: "Output") -> str:
    from live.render.outputs.output_pass import read_mask

    height, width = read_mask(output).shape
    return f"{width}x{height} pixels"


def _run_check(what: str, describe: Callable[[], str], remedy: str) -> Check:
    """Return a check with the text of `describe`, or its error."""
    try:
        return Check(what, "ok", describe(), needed=True)
    except PersonError as error:
        return Check(what, "missing", error.message.replace("\n", " "), error.remedy or remedy, needed=True)


def venue_checks(venue: Venue | None, name: str | None = None) -> Iterator[Check]:
    """Yield checks of the devices and projectors that a venue names; `name`: the venue's."""
    if venue is None:
        return
    yield from output_checks(venue, name)
    yield from certificate_checks(venue, name)
    inputs, outputs = audio_sections()
    wanted = venue.audio
    for what, name, there in (
        ("audio.device", wanted.device, inputs), ("audio.output", wanted.output, outputs),
        ("audio.click", wanted.click, outputs),
    ):  # fmt: skip
        if name is not None:
            yield _device(what, name, there)
    midi_in, midi_out = midi_sections()
    for what, name, there in (
        ("midi.input", venue.midi.input, midi_in),
        ("midi.output", venue.midi.output, midi_out),
        ("midi.clock_out", venue.midi.clock_out, midi_out),
    ):
        if name is not None:
            yield _device(what, name, there)


def certificate_checks(venue: Venue, name: str | None) -> Iterator[Check]:
    """Yield checks of the audience server's TLS certificate: its files and validity."""
    from live.app.services.audience_tls import read_identity, venue_tls_files

    files = venue_tls_files(venue.audience, name)
    if files is None:
        return
    try:
        identity = read_identity(*files, name="audience.certificate")
    except PersonError as error:
        yield Check(
            "audience.certificate", "missing", error.message, error.remedy or "have it issued again", needed=True
        )
        return
    doubts = identity.warnings(datetime.now(UTC), identity.host or identity.names[0] if identity.names else "")
    for words in doubts:
        yield Check("audience.certificate", "limited", words, "renew it, or correct its files")
    if not doubts:
        words = f"{identity.host or ', '.join(identity.names)}, until {identity.valid_until:%Y-%m-%d}"
        yield Check("audience.certificate", "ok", words, needed=True)


def _device(what: str, name: str, section: Section) -> Check:
    """Check for a device whose name contains `name`."""
    found = [str(item["name"]) for item in section.items if name.casefold() in str(item["name"]).casefold()]
    if found:
        return Check(what, "ok", found[0], needed=True)
    known = ", ".join(str(item["name"]) for item in section.items) or section.why or "none"
    return Check(what, "missing", f"{name!r} not found", f"plug it in, or name one of: {known}", needed=True)


def check_osc(host: str, port: int) -> Check:
    """Check that the show can receive OSC at this address: listen, and send a test packet."""
    from live.base.event_queue import PriorityQueue
    from live.clock.time_source import SystemClock
    from live.control.osc.osc_server import OscInput
    from live.control.osc.osc_socket import CannotListen

    listener = OscInput(host, port, PriorityQueue(), SystemClock())
    try:
        listener.start()
    except CannotListen as error:
        return Check("OSC", "missing", str(error), "end the other program, or play with --osc HOST:PORT", needed=True)
    try:
        return _send_test_packet(listener, "127.0.0.1" if host in ("0.0.0.0", "") else host)
    finally:
        listener.stop()


def _send_test_packet(listener: object, host: str) -> Check:
    from live.rehearse.network_sender import packet_of
    from live.rehearse.simulated_players import Call

    port = listener.port  # type: ignore[attr-defined]
    packet = packet_of(Call(0.0, "/dance/ping", [], "check"))
    assert packet is not None
    try:
        address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        with socket.socket(address[0], socket.SOCK_DGRAM) as probe:
            probe.settimeout(OSC_TIMEOUT_S)
            probe.sendto(packet, address[4])
            probe.recv(1024)
    except OSError as error:
        words = f"udp {host}:{port}: a test packet is not answered ({error})"
        return Check("OSC", "missing", words, "check the firewall", needed=True)
    return Check("OSC", "ok", f"udp {host}:{port}: the test packet was answered", needed=True)


def check_disk(folder: Path) -> Check:
    """Check disk space for a journal and for a film."""
    try:
        free = shutil.disk_usage(folder).free / 1e6
    except OSError as error:
        return Check("disk", "limited", f"{folder}: {error}", "write journals elsewhere")
    detail = f"{free / 1000.0:.1f} GB free in {folder}"
    least, enough = MIN_FREE_MB
    if free < least:
        return Check("disk", "missing", f"{detail}: no space for a journal", "free some space", needed=True)
    if free < enough:
        return Check("disk", "limited", f"{detail}: enough for a journal, not for a film", "free some space")
    return Check("disk", "ok", detail, needed=True)


def check_music(loaded: LoadedShow) -> Check:
    """Check that the patch's music file exists."""
    try:
        path = loaded.music_path
    except PersonError as error:
        return Check("music", "missing", error.message, error.remedy or "", needed=True)
    return Check("music", "ok", "none in the patch" if path is None else str(path))


def all_venue_checks(
    loaded: LoadedShow, show: Show, venue: Venue | None, osc: tuple[str, int], name: str | None = None
) -> list[Check]:
    """Return every check in table order; `name`: the venue's."""
    return [
        *show_checks(loaded, show),
        check_music(loaded),
        *venue_checks(venue, name),
        *part_checks(loaded, venue),
        check_osc(*osc),
        check_monitors(),
        check_opengl(),
        check_kernels(),
        check_disk(Path.cwd()),
    ]
