"""The key of the operator's page: created once, readable by its owner only, the same for every process of a show."""

import os
import stat

import pytest

from live.app.launch_options import LaunchOptions
from live.app.services.http_services import key_file, parse_web, stored_key
from live.base.errors import PersonError


@pytest.fixture(autouse=True)
def settings(tmp_path, monkeypatch):
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(tmp_path / "a" / "b"))
    return tmp_path / "a" / "b"


def web(text="8010", key=None, new_key=False, hosts=()):
    return parse_web(text, key=key, new_key=new_key, hosts=hosts)


@pytest.mark.parametrize("where", ["8010", "127.0.0.1:0", "localhost:8010", "[::1]:8010", "0.0.0.0:8010", "[::]:8010"])
def test_every_page_has_persistent_key(where):
    first = web(where)
    assert len(first.key) >= 22, "128 bits"
    assert web(where).key == first.key == key_file().read_text().strip()
    assert stat.S_IMODE(key_file().stat().st_mode) == 0o600
    assert stat.S_IMODE(key_file().parent.stat().st_mode) == 0o700
    other = web(where, new_key=True)
    assert other.key != first.key
    assert web(where).key == other.key
    assert os.listdir(key_file().parent) == ["web-key"], "nothing is left beside it"


def test_key_is_not_created_without_page(settings):
    assert web(None).bind_address is None
    assert web(None, key="a-key-of-my-own-1234").key == ""
    assert not settings.exists()
    with pytest.raises(PersonError, match="no web page without --web"):
        web(None, new_key=True)


def test_given_key_is_used_and_not_stored(settings):
    assert web(key="a-key-of-my-own-1234").key == "a-key-of-my-own-1234"
    assert not settings.exists()
    with pytest.raises(PersonError, match="a key was given"):
        web(key="a-key-of-my-own-1234", new_key=True)


WEAK = (
    "", "short", "x" * 15, "x" * 129, "a" * 20, "ababababababababab", "with a space in it 12",
    "ein-schlüssel-der-länger-ist", "a-key-of-my-own-1234\n", "a-key\0of-my-own-1234", "../../etc/passwd/1",
)  # fmt: skip


@pytest.mark.parametrize("key", WEAK)
def test_weak_and_invalid_keys_are_refused_and_not_printed(key):
    with pytest.raises(PersonError, match="16 to 128 letters") as error:
        web(key=key)
    assert len(key) < 3 or key not in str(error.value)


@pytest.mark.parametrize("mode", [0o644, 0o640, 0o602, 0o610])
def test_key_file_readable_by_others_is_refused(mode):
    stored_key()
    key_file().chmod(mode)
    with pytest.raises(PersonError, match="readable by you only") as error:
        stored_key()
    assert error.value.remedy == "--new-web-key generates a new one"
    assert stored_key(fresh=True) == stored_key()
    assert stat.S_IMODE(key_file().stat().st_mode) == 0o600


@pytest.mark.parametrize(
    "text", [b"", b"\n", b"short\n", b"\xff" * 30, b"x" * 5000, b"two-lines-of-key-1\ntwo", b"\0" * 30]
)
def test_invalid_key_in_file_is_refused_by_name(text):
    stored_key()
    key_file().write_bytes(text)
    with pytest.raises(PersonError, match="web-key, line 1"):
        stored_key()
    assert stored_key(fresh=True) == stored_key()


def test_links_pipes_and_folders_are_not_read(tmp_path):
    stored_key()
    elsewhere = tmp_path / "elsewhere"
    elsewhere.write_text("a-key-of-somebody-else-1234\n")
    elsewhere.chmod(0o600)
    for place in (
        lambda path: path.symlink_to(elsewhere), lambda path: path.symlink_to(path),
        lambda path: os.mkfifo(path, 0o600),  # nobody waits for a writer
    ):  # fmt: skip
        key_file().unlink()
        place(key_file())
        with pytest.raises(PersonError, match="has to be a file, no link"):
            stored_key()
        assert stored_key(fresh=True) == stored_key()
    key_file().unlink()
    key_file().mkdir()
    with pytest.raises(PersonError, match="has to be a file, no link"):
        stored_key()
    assert elsewhere.read_text() == "a-key-of-somebody-else-1234\n"


def test_unwritable_key_is_valid_for_this_show_only(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(tmp_path / "file" / "below"))
    notes = []
    first, second = stored_key(note=notes.append), stored_key(note=notes.append)
    assert first != second
    assert min(len(first), len(second)) >= 22
    assert len(notes) == 2


@pytest.mark.parametrize(
    "host", ["", "a b", "*", "*.local", "http://x", "x/y", "x:", "x:123456", "-x", "x.", "x" * 300, "x\n"]
)
def test_invalid_hosts_are_refused(host):
    with pytest.raises(PersonError, match="NAME or NAME:PORT"):
        web(hosts=[host])


def test_key_is_hidden_in_repr_of_options():
    access = web(hosts=["show.example", "show.example:443"])
    assert access.hosts == ("show.example", "show.example:443")
    options = LaunchOptions(web=access.bind_address, web_key=access.key)
    assert access.key not in repr(access)
    assert access.key not in repr(options)
