"""Phones over https: valid, wrong, expired or readable certificates, and a gateway that is restarted."""

import asyncio
import contextlib
import datetime
import ipaddress
import os
import signal
import socket
import ssl

import aiohttp
import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from live.app.launch_options import LaunchOptions
from live.app.machine.venue_check import certificate_checks
from live.app.services.audience_service import AudienceService, network_of, tls_files
from live.app.services.audience_tls import parse_tls, read_identity
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.clock.time_source import ManualClock
from live.show.patch.section_io import AudienceSection
from live.show.venue.venue import Venue
from tests.app.services.test_audience_service import Stage
from tests.control.audience.made_gateway import FakePhone, until
from tests.show.made_show import made_show

NOW = datetime.datetime.now(datetime.UTC)
DAY = datetime.timedelta(days=1)


def write_certificate(
    folder, name="hall", *, begins=NOW - DAY, ends=NOW + 30 * DAY, hosts=("play.example",), password=None
):
    """A certificate and its key in files; returns both paths."""
    key = ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "hall")])
    names = [x509.DNSName(host) for host in hosts] + [x509.IPAddress(ipaddress.ip_address("127.0.0.1"))]
    certificate = (
        x509.CertificateBuilder().subject_name(subject).issuer_name(subject).public_key(key.public_key())
        .serial_number(x509.random_serial_number()).not_valid_before(begins).not_valid_after(ends)
        .add_extension(x509.SubjectAlternativeName(names if hosts else names[1:]), critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=None), critical=True)
        .sign(key, hashes.SHA256())
    )  # fmt: skip
    paths = folder / f"{name}.pem", folder / f"{name}.key"
    paths[0].write_bytes(certificate.public_bytes(serialization.Encoding.PEM))
    locked = serialization.BestAvailableEncryption(password) if password else serialization.NoEncryption()
    form = serialization.PrivateFormat.PKCS8
    paths[1].write_bytes(key.private_bytes(serialization.Encoding.PEM, form, locked))
    paths[1].chmod(0o600)
    return paths


@pytest.fixture
def notes(monkeypatch):
    """Notes printed for the operator."""
    told = []
    monkeypatch.setattr(AudienceService, "_print_note", staticmethod(lambda words, _style: told.append(words)))
    return told


@pytest.mark.long
def test_phones_play_over_tls_and_return_after_gateway_is_killed(tmp_path, notes):
    files = write_certificate(tmp_path)
    stage = Stage(audience_tls=files)

    async def test(_session):
        part = stage.part
        assert part.address == f"https://127.0.0.1:{part.port}"
        assert part.link.startswith(part.address + "/#")
        assert notes == [f"note: audience: {part.invitation_link}, on this machine only"]
        trust = ssl.create_default_context(cafile=str(files[0]))
        for path in files:
            path.unlink()
        async with aiohttp.ClientSession(connector=aiohttp.TCPConnector(ssl=trust, limit=0)) as session:
            async with session.get(part.address) as answer:
                assert b"Dance with us" in await answer.read()
            phone = await FakePhone(session, part.address).join(part.link.partition("#")[2])
            await phone.touch(1, 1.0, 0.5)
            await until(lambda: any(e.source == "audience 1" for e in stage.show.motion.elements.in_force))
            mute = [socket.create_connection(("127.0.0.1", part.port)) for _ in range(10)]  # no handshake ever comes
            mute[0].sendall(b"GET / HTTP/1.1\r\n\r\n")  # no TLS at all
            await until(lambda: stage.clock.now() > 2.2)
            os.kill(part.pid, signal.SIGKILL)
            again = None
            while again is None:
                try:
                    again = await FakePhone(session, part.address).join(token=phone.token)
                except (aiohttp.ClientError, OSError):
                    await asyncio.sleep(0.05)
            assert again.number == phone.number
            mute += [socket.create_connection(("127.0.0.1", part.port)) for _ in range(10)]
            for one in mute:
                one.settimeout(20.0)  # each is closed, and needs at most some 5 s for it
                with contextlib.suppress(ConnectionError):
                    while await asyncio.to_thread(one.recv, 4096):
                        pass
                one.close()

    asyncio.run(asyncio.wait_for(stage.play(test), 120.0))


def test_certificate_expiring_during_show_is_reported_once_and_gateway_continues(tmp_path, notes):
    files = write_certificate(tmp_path, ends=NOW + datetime.timedelta(hours=1))
    clock = ManualClock()
    options = LaunchOptions(audience=("127.0.0.1", 0), audience_secret=b"s" * 32, audience_tls=files)
    part = AudienceService(options, made_show(), EventQueue().add_queue(), clock)
    part.start()
    try:
        assert [words for words in notes if "expires on" in words]
        part.frame()
        assert not [words for words in notes if "has expired" in words]
        clock.advance(3700.0)
        for _ in range(3):
            part.frame()
        assert len([words for words in notes if "has expired" in words]) == 1
        assert part.pid is not None
        assert part.status()["certificate_until"].endswith("Z")
    finally:
        part.stop()


def test_expired_foreign_and_readable_certificates_are_reported_and_show_begins(tmp_path, notes):
    certificate, key = write_certificate(tmp_path, ends=NOW - datetime.timedelta(hours=1), hosts=("*.play.example",))
    key.chmod(0o644)
    identity = read_identity(certificate, key)
    told = identity.warnings(NOW, "stage.local")
    assert any("expired on" in words and "renew" in words for words in told)
    assert any(f"chmod 600 {key}" in words for words in told)
    assert any("is for *.play.example, 127.0.0.1, but phones are given stage.local" in words for words in told)
    assert not [words for words in identity.warnings(NOW, "hall.play.example") if "phones are given" in words]
    assert [words for words in identity.warnings(NOW, "a.b.play.example") if "phones are given" in words]
    assert [words for words in identity.warnings(NOW - 90 * DAY, "127.0.0.1") if "valid from" in words]
    options = LaunchOptions(audience=("127.0.0.1", 0), audience_secret=b"s" * 32, audience_tls=(certificate, key))
    part = AudienceService(options, made_show(), EventQueue().add_queue(), ManualClock())
    part.start()
    part.stop()
    assert [words for words in notes if "expired on" in words]


def test_resumed_engine_runs_without_audience_when_files_are_gone(tmp_path, notes):
    files = write_certificate(tmp_path)
    files[1].unlink()
    options = LaunchOptions(audience=("127.0.0.1", 0), audience_secret=b"s" * 32, audience_tls=files)
    with pytest.raises(PersonError, match=r"cannot read .*hall\.key"):
        AudienceService(
            options, made_show(), EventQueue().add_queue(), ManualClock()
        ).start()  # before the show: it is put right
    part = AudienceService(options, made_show(), EventQueue().add_queue(), ManualClock(90.0))
    part.resumes = True
    part.start()
    for each in (part.before_frame, part.frame, part.stop):
        each()
    assert part.status()["at"]
    assert [words for words in notes if "the show runs without its audience" in words]


def test_link_contains_host_name_of_certificate(tmp_path, notes):
    certificate, key = write_certificate(tmp_path, hosts=("*.x.example", "play.example"))
    part = AudienceService(
        LaunchOptions(audience=("127.0.0.2", 0), audience_secret=b"s" * 32, audience_tls=(certificate, key)),
        made_show(), EventQueue().add_queue(), ManualClock(),
    )  # fmt: skip
    part.start()
    try:
        assert part.address == f"https://play.example:{part.port}"
    finally:
        part.stop()


def test_invalid_files_are_refused_with_remedy(tmp_path):
    certificate, key = write_certificate(tmp_path)
    other, other_key = write_certificate(tmp_path, "other")
    _, locked = write_certificate(tmp_path, "locked", password=b"x")
    rubbish, large = tmp_path / "rubbish", tmp_path / "large"
    rubbish.write_bytes(os.urandom(3000))
    large.write_bytes(b"x" * 30_000)
    broken = tmp_path / "broken"
    broken.write_bytes(b"-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n")
    os.mkfifo(tmp_path / "pipe")
    for files, words in (
        ((certificate, other_key), "does not belong to the certificate"),
        ((key, certificate), "give the certificate first"),
        ((certificate, locked), "encrypted with a password .*openssl pkey"),
        ((rubbish, key), "holds no certificate in PEM"),
        ((broken, key), "holds no certificate in PEM"),
        ((certificate, rubbish), "holds no key in PEM"),
        ((large, key), "larger than"),
        ((tmp_path / "none.pem", key), "cannot read .*none.pem"),
        ((tmp_path, key), "cannot read"),
        ((tmp_path / "pipe", key), "cannot read"),
        ((tmp_path / "a\0b", key), "not a valid file name"),
    ):
        with pytest.raises(PersonError, match=words):
            read_identity(*files)
    assert read_identity(other, other_key).host == "play.example"
    assert parse_tls(None) is None
    assert [path.name for path in parse_tls("a.pem, b.key")] == ["a.pem", "b.key"]
    for text in ("", "a.pem", "a,b,c", ",b", "a,"):
        with pytest.raises(PersonError, match="CERT,KEY"):
            parse_tls(text)


def test_venue_files_are_relative_to_venue_and_command_line_has_priority(tmp_path, monkeypatch):
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(tmp_path))
    (tmp_path / "venues").mkdir()
    (tmp_path / "venues" / "hall.toml").write_text('[audience]\ncertificate = "a.pem"\nkey = "/etc/b.key"\n')
    options = LaunchOptions(venue="hall")
    found = tls_files(options, options.read_venue().audience)
    assert found == (tmp_path / "venues" / "a.pem", type(tmp_path)("/etc/b.key"))
    assert tls_files(options, Venue().audience) is None
    own = type(tmp_path)("x"), type(tmp_path)("y")
    assert tls_files(LaunchOptions(venue="hall", audience_tls=own), options.read_venue().audience) == own


def test_venue_check_includes_certificate(tmp_path, monkeypatch):
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(tmp_path))
    folder = tmp_path / "venues"
    folder.mkdir()

    def look(**how):
        write_certificate(folder, **how)
        text = '[audience]\ncertificate = "hall.pem"\nkey = "hall.key"\n'
        (folder / "hall.toml").write_text(text)
        return [(one.state, one.detail) for one in certificate_checks(LaunchOptions(venue="hall").read_venue(), "hall")]

    assert list(certificate_checks(Venue(), None)) == []
    [(state, words)] = look()
    assert (state, words[:20]) == ("ok", "play.example, until ")
    [(state, words)] = look(ends=NOW + DAY)
    assert (state, "renew it soon" in words) == ("limited", True)
    (folder / "hall.key").unlink()
    [found] = certificate_checks(LaunchOptions(venue="hall").read_venue(), "hall")
    assert (found.state, "hall.key" in str(found)) == ("missing", True)


def test_network_without_venue_entry_has_default():
    assert network_of(AudienceSection(), public=True) == "own wifi"
    assert network_of(AudienceSection(), public=False) == "behind nat"  # to try it out with many tabs
    assert network_of(AudienceSection(phones=300, phones_per_address=300), public=True) == "behind nat"
