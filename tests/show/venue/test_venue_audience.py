"""`[audience]` of a venue: what may stand there, and what a person is told of what may not."""

import pytest

from live.base.errors import PersonError
from live.show.patch.patch_reader import parse_model
from live.show.venue.venue import Venue


def hall(text):
    return parse_model(f'name = "hall"\n[audience]\n{text}', "hall.toml", Venue, "venue").audience


def test_what_may_stand_there():
    assert hall("").network is None
    read = hall(
        'network = "proxy"\nproxies = ["192.168.1.2", "10.0.0.7/24", "2001:db8::/48"]\ncode_s = 20\ngrace_s = 60\n'
        'joins_per_code = 300\nby_card = false\ncertificate = "hall.pem"\nkey = "/etc/hall.key"\n'
    )
    assert (read.network, read.code_s, read.joins_per_code) == ("proxy", 20.0, 300)
    assert hall('network = "behind nat"').network == "behind nat"
    assert hall('network = "own wifi"').by_card


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ('network = "wifi"', 3, "audience.network: .*'own wifi', 'behind nat' or 'proxy'"),
        ('network = "proxy"', 3, 'network = "proxy" needs proxies'),
        ('network = "own wifi"\nproxies = ["10.0.0.1", "hall.local"]', 4, r"audience.proxies.2: .*found 'hall.local'"),
        ('proxies = ["0.0.0.0/0"]', 3, "matches every address"),
        ('proxies = ["::/0"]', 3, "matches every address"),
        ('certificate = "a.pem"', 3, "audience.certificate: certificate and key belong together"),
        ('key = "a.key"', 3, "audience.key: certificate and key belong together"),
        ("code_s = 5", 3, "greater than or equal to 10"),
        ("grace_s = inf", 3, "finite"),
        ("joins_per_code = 0", 3, "greater than or equal to 1"),
        ("netwrok = 1", 3, "did you mean 'network'"),
    ],
)
def test_what_is_wrong_is_told_with_its_line_and_its_remedy(text, line, words):
    with pytest.raises(PersonError, match=words) as told:
        hall(text)
    assert f"hall.toml:{line}:" in str(told.value) or f"hall.toml, line {line}" in str(told.value)
