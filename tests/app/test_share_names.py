"""Parsing of picture share names and addresses."""

import pytest

from live.app import option_values
from live.app.option_values import parse_shares
from live.base.errors import PersonError


def test_names_and_addresses_are_parsed() -> None:
    given = ["shm:stage", "udp://127.0.0.1:5000", "udp://239.0.0.1:5000?ttl=2", "tcp://[::1]:7000", "shm:stage"]
    assert parse_shares(given) == tuple(given[:4])
    assert parse_shares(None) == ()


@pytest.mark.parametrize(
    "text", ["", "stage", "shm:", "shm:../x", "udp:127.0.0.1", "udp://127.0.0.1", "udp://host:0", "udp://host:70000",
             "http://host:80", "rtmp://host:1935/live"],
)  # fmt: skip
def test_invalid_shares_are_refused(text: str) -> None:
    with pytest.raises(PersonError, match="--share"):
        parse_shares([text])


def test_missing_srt_support_is_reported_with_alternative(monkeypatch: pytest.MonkeyPatch) -> None:
    import live.render.film.network_stream as stream

    monkeypatch.setattr(stream, "is_srt_supported", lambda: False)
    with pytest.raises(PersonError, match="built without SRT") as error:
        option_values.parse_shares(["srt://127.0.0.1:5000"])
    assert "ffmpeg -i udp://" in str(error.value.remedy)
    monkeypatch.setattr(stream, "is_srt_supported", lambda: True)
    assert option_values.parse_shares(["srt://127.0.0.1:5000"]) == ("srt://127.0.0.1:5000",)
