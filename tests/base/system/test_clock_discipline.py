"""What disciplines the clock, in words, from the programs that run."""

from live.base.system.clock_discipline import Discipline, clock_discipline


def test_programs_are_named_once_and_others_do_not_count():
    found = clock_discipline(["bash", "ptp4l", "phc2sys", "chronyd", "chronyd"])
    assert found.programs == ("NTP (chrony)", "PTP (linuxptp)")
    assert clock_discipline(["systemd-timesyn"]).programs == ("NTP (systemd-timesyncd)",)


def test_words_say_what_the_kernel_says():
    assert str(Discipline((), False)) == "none, not synchronised"
    assert str(Discipline(("NTP (chrony)",), True)) == "NTP (chrony), synchronised"
    assert str(Discipline(("NTP (chrony)",), None)) == "NTP (chrony)"


def test_this_machine_answers():
    assert isinstance(clock_discipline(), Discipline)
