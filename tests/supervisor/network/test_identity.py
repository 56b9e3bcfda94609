"""Keys and pairings on disk: file modes, atomic writes, and refusal of invalid or readable files."""

import datetime
import os
from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.supervisor.network import identity as module
from live.supervisor.network.identity import load_identity, safe_name
from tests.supervisor.made_machines import machine, network


def test_key_is_created_once_with_private_file_mode(tmp_path: Path):
    folder = network(tmp_path / "config")
    first, again = load_identity(folder), load_identity(folder)
    assert first.fingerprint == again.fingerprint
    assert (folder.stat().st_mode & 0o777, first.path.stat().st_mode & 0o777) == (0o700, 0o600)
    assert first.as_peer().verify(again.sign(b"words"), b"words")
    assert not first.as_peer().verify(first.sign(b"words"), b"other words")
    assert sorted(path.name for path in folder.iterdir()) == ["identity.pem"]


@pytest.mark.parametrize(("what", "mode", "remedy"), [("identity.pem", 0o640, "chmod 600"), (".", 0o755, "chmod 700")])
def test_key_readable_by_others_is_refused(tmp_path: Path, what, mode, remedy):
    folder = network(tmp_path / "config")
    load_identity(folder)
    (folder / what).chmod(mode)
    with pytest.raises(PersonError, match="not this user's alone") as raised:
        load_identity(folder)
    assert remedy in str(raised.value.remedy)


@pytest.mark.parametrize(
    "words", [b"", b"\x80\x04K\x01.", b"-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n"]
)
def test_key_file_without_key_is_named_in_error(tmp_path: Path, words):
    folder = network(tmp_path / "config")
    path = load_identity(folder).path
    path.write_bytes(words)
    with pytest.raises(PersonError, match="does not hold this machine's key"):
        load_identity(folder)


def test_machines_are_paired_listed_and_forgotten(tmp_path: Path):
    _, pairings = machine(tmp_path / "mine")
    theirs, others = machine(tmp_path / "theirs")[0], machine(tmp_path / "others")[0]
    seen = pairings.version()
    assert pairings.add("stage left/../x", theirs.certificate).name == "stage-left-..-x"
    assert pairings.add("another name", theirs.certificate).name == "stage-left-..-x"  # one that is known stays
    assert pairings.add("stage left/../x", others.certificate).name == "stage-left-..-x-2"
    assert pairings.version() != seen
    assert [peer.fingerprint for peer in pairings.read()] == [theirs.fingerprint, others.fingerprint]
    files = list((network(tmp_path / "mine") / "paired").iterdir())
    assert {path.stat().st_mode & 0o777 for path in files} == {0o600}
    assert not pairings.forget("../identity")
    assert not pairings.forget("nobody")
    assert pairings.forget("stage-left-..-x")
    assert [peer.name for peer in pairings.read()] == ["stage-left-..-x-2"]


def test_invalid_certificate_is_refused_as_pairing(tmp_path: Path):
    _, pairings = machine(tmp_path / "mine")
    with pytest.raises(ValueError, match=r"."):
        pairings.add("x", b"no certificate")
    pairings.add("x", machine(tmp_path / "theirs")[0].certificate)
    path = network(tmp_path / "mine") / "paired" / "x.pem"
    path.write_text("no certificate")
    with pytest.raises(PersonError, match=r"x\.pem is no certificate") as raised:
        pairings.read()
    assert raised.value.remedy == "live pair --forget x"
    path.chmod(0o644)
    with pytest.raises(PersonError, match="not this user's alone"):
        pairings.read()


def test_certificate_contains_expiry_date(tmp_path: Path, monkeypatch):
    monkeypatch.setattr(module, "VALID", datetime.timedelta(seconds=-5))
    peer = load_identity(network(tmp_path / "config")).as_peer()
    assert peer.expires < datetime.datetime.now(datetime.UTC)


@pytest.mark.parametrize("name", ["", "...", "\x1b[2J", "a" * 300, "übung 1"])
def test_any_name_becomes_valid_file_name(name):
    plain = safe_name(name)
    assert plain
    assert len(plain) <= 40
    assert os.sep not in plain
    assert plain.isascii()
