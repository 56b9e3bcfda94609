"""Nothing that a file says is obeyed by the terminal it is shown on."""

from live.base.errors import PersonError, printable


def test_what_a_terminal_obeys_is_spelled_out():
    assert printable("\x1b[2J\x07\x9b1m\x00") == r"\x1b[2J\x07\x9b1m\x00"
    assert printable("\u202eevil \udc80") == r"\u202eevil \udc80"
    assert printable("Ägypten, 舞踊\tgo\n") == "Ägypten, 舞踊\tgo\n"


def test_messages_for_people_are_printable():
    error = PersonError("group '\x1b]0;x\x07'", "not \x1b[2J")
    assert str(error) == r"group '\x1b]0;x\x07' (not \x1b[2J)"
    str(error).encode()
