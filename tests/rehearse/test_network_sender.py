"""Network sender: OSC packets, MIDI clock and sound are what a show receives, sent when due."""

import heapq
import wave
from itertools import islice, pairwise

import numpy as np
import pytest

from live.control.osc.osc_codec import decode
from live.rehearse.network_sender import CLOCK, START, STOP, UdpSender, clock_pulses, packet_of, send_all
from live.rehearse.simulated_band import RATE, Irregularities, SimulatedBand, render_audio, write_sound
from live.rehearse.simulated_players import Call

CALM = Irregularities(stop=0.0, fill=0.0, wrong_downbeat=0.0, tempo_jump=0.0, drift=0.0)


def test_call_is_decoded_as_it_was_sent():
    call = Call(1.0, "/dance/formation", ["circle", 4.0, "*", True, None], "phone 1")
    (message,) = decode(packet_of(call))
    assert message.address == "/dance/formation"
    assert list(message.arguments) == ["circle", 4.0, "*", True, None]


def test_call_without_osc_types_is_not_sent():
    assert packet_of(Call(1.0, "/dance/attract", [1e300, object()], "phone 1")) is None


def test_midi_clock_of_band_has_24_pulses_per_beat():
    coming = list(islice(clock_pulses(SimulatedBand(1, bpm=120.0, irregularities=CALM)), 1 + 24 * 40))
    assert coming[0] == (0.5, START)
    times = [time for time, what in coming if what == CLOCK]
    assert len(times) == 24 * 40
    assert np.diff(times).mean() == pytest.approx(0.5 / 24.0, rel=0.01)


def test_midi_clock_stops_and_restarts_with_rests():
    coming = list(islice(clock_pulses(SimulatedBand(2, irregularities=Irregularities(stop=0.5))), 5000))
    kinds = [what for _, what in coming if what != CLOCK]
    assert kinds[0] == START
    assert len(kinds) > 10
    assert all({a, b} == {START, STOP} for a, b in pairwise(kinds))
    assert all(a[0] <= b[0] + 1e-9 for a, b in pairwise(coming))


def test_streams_are_sent_in_time_order_and_not_early():
    time, sent = [0.0], []

    def wait(seconds):
        time[0] += seconds
        return False

    streams = [
        (iter([(0.1 * n, b"a%d" % n) for n in range(20)]), lambda what: sent.append((time[0], what))),
        (iter([(0.05 + 0.3 * n, b"b%d" % n) for n in range(20)]), lambda what: sent.append((time[0], what))),
    ]
    send_all(streams, now=lambda: time[0], wait=wait, until=2.0)
    due = [*((0.1 * n, b"a%d" % n) for n in range(20)), *((0.05 + 0.3 * n, b"b%d" % n) for n in range(7))]
    assert [what for _, what in sent] == [what for _, what in heapq.merge(sorted(due))]
    assert all(at >= when - 1e-9 for (at, _), (when, _) in zip(sent, sorted(due), strict=True))
    assert time[0] == pytest.approx(2.0)


def test_udp_packets_reach_their_address():
    import socket

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as there:
        there.bind(("127.0.0.1", 0))
        there.settimeout(5.0)
        outlet = UdpSender("127.0.0.1", there.getsockname()[1])
        outlet.send(b"abcd")
        assert there.recv(100) == b"abcd"
        outlet.close()
        outlet.send(b"efgh")
        assert (outlet.sent, outlet.failed) == (1, 1)


def test_rendered_sound_has_onsets_on_band_beats(tmp_path):
    sound = render_audio(SimulatedBand(3, bpm=120.0, irregularities=CALM), 8.0)
    assert np.abs(sound).max() < 1.0
    energy = np.square(sound[: len(sound) // 441 * 441]).reshape(-1, 441).mean(axis=1)  # in hundredths of a second
    played = [beat.time for beat in islice(SimulatedBand(3, bpm=120.0, irregularities=CALM).beats(), 14)]
    for time in played:
        at = round(time * 100)
        assert energy[at : at + 6].max() > 20.0 * energy[at - 6 : at - 1].mean()
    write_sound(tmp_path / "band.wav", sound)
    with wave.open(str(tmp_path / "band.wav")) as file:
        assert (file.getframerate(), file.getnframes()) == (RATE, len(sound))
