"""`[audience]` of a venue: valid keys, and errors with line and remedy."""

import pytest

from live.base.errors import PersonError
from live.show.patch.toml_model import parse_model
from live.show.venue.venue import Venue


def audience_of(text):
    return parse_model(f'name = "hall"\n[audience]\n{text}', "hall.toml", Venue, "venue").audience


def test_valid_audience_section_is_read():
    assert audience_of("").network is None
    read = audience_of(
        'network = "proxy"\nproxies = ["192.168.1.2", "10.0.0.7/24", "2001:db8::/48"]\ncode_s = 20\ngrace_s = 60\n'
        'joins_per_code = 300\nby_card = false\ncertificate = "hall.pem"\nkey = "/etc/hall.key"\n'
    )
    assert (read.network, read.code_s, read.joins_per_code) == ("proxy", 20.0, 300)
    assert audience_of('network = "behind nat"').network == "behind nat"
    assert audience_of('network = "own wifi"').by_card


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
def test_invalid_audience_key_is_refused_with_line_and_remedy(text, line, words):
    with pytest.raises(PersonError, match=words) as told:
        audience_of(text)
    assert f"hall.toml:{line}:" in str(told.value) or f"hall.toml, line {line}" in str(told.value)
