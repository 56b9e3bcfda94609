"""Control characters in file texts do not reach the terminal."""

from live.base.errors import PersonError, printable


def test_control_characters_are_escaped():
    assert printable("\x1b[2J\x07\x9b1m\x00") == r"\x1b[2J\x07\x9b1m\x00"
    assert printable("\u202eevil \udc80") == r"\u202eevil \udc80"
    assert printable("Ägypten, 舞踊\tgo\n") == "Ägypten, 舞踊\tgo\n"


def test_person_error_messages_are_printable():
    error = PersonError("group '\x1b]0;x\x07'", "not \x1b[2J")
    assert str(error) == r"group '\x1b]0;x\x07' (not \x1b[2J)"
    str(error).encode()
