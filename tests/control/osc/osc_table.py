"""Messages to every control as an external program sends them, and the resulting events.

An address, the arguments of liblo's oscsend (type tags, then a value for each that has one), the event.
"""

import struct

from live.base.motion_parameters import MOTION_PARAMETERS
from live.base.picture_parameters import GROUP_PARAMETERS, PARAMETERS
from live.control.events import events
from live.control.registry.registry import REGISTRY
from tests.control.osc.osc_stage import STAMP


def every_control():
    """All rows of all tables, and a usual message to each control that has none."""
    return {control.address: usual_message(control) for control in REGISTRY} | {
        "/dance/attract": (["ff", "1.5", "-2"], events.PlaceElement(kind="attract", points=((1.5, -2.0),), **STAMP)),
        "/dance/repel": (
            ["fidh", "1", "2", "0.5", "8"],
            events.PlaceElement(kind="repel", points=((1.0, 2.0),), strength=0.5, measures=8.0, **STAMP),
        ),
        "/dance/spread": (["f", "2"], events.PlaceElement(kind="spread", measures=2.0, **STAMP)),
        "/dance/clear": ([], events.Clear(**STAMP)),
        "/dance/now": (["ssf", "jump", "tide", "2"], events.StepNow(name="jump", group="tide", measures=2.0, **STAMP)),
        "/dance/step": (["s", "side step"], events.CallStep(name="side step", **STAMP)),
        "/dance/clock/tap": ([], events.Tap(**STAMP)),
        "/dance/clock/one": (["I"], events.One(**STAMP)),
        "/dance/clock/tempo": (["d", "132.5"], events.SetTempo(tempo=132.5, **STAMP)),
        **clock_and_sound_controls(),
        "/dance/sequence": (
            ["ss", "sway, glide x2, *", "front"],
            events.SetSequence(steps="sway, glide x2, *", group="front", **STAMP),
        ),
        **parameter_controls(),
        "/dance/partner/on": (["i", "0"], events.SetPartner(parameter="on", value=0.0, **STAMP)),
        "/dance/partner/amount": (
            ["fs", "0.5", "duet"],
            events.SetPartner(parameter="amount", value=0.5, partner="duet", **STAMP),
        ),
        "/dance/partner/stretch": (["f", "0.125"], events.SetPartner(parameter="window", value=0.125, **STAMP)),
        "/dance/partner/hands": (
            ["fs", "0.25", "duet"],
            events.SetPartner(parameter="hands", value=0.25, partner="duet", **STAMP),
        ),
        "/dance/partner/style": (["ss", "soft", "duet"], events.StylePartner(style="soft", partner="duet", **STAMP)),
        "/dance/partner/path": (
            ["ffsi", "1.5", "-0.5", "walk", "1"],
            events.WalkOn(x=1.5, z=-0.5, partner="walk", anew=True, **STAMP),
        ),
        "/dance/partner/leader": (
            ["ss", "ember & 1", "duet"],
            events.PairPartner(role="leader", who="ember & 1", partner="duet", **STAMP),
        ),
        "/dance/partner/follower": (
            ["s", "tide"],
            events.PairPartner(role="follower", who="tide", partner="*", **STAMP),
        ),
        "/dance/facing": (
            ["ss", "dancer 3", "left"],
            events.SetFacing(facing="dancer 3", group="left", **STAMP),
        ),
        "/dance/why": (["i", "7"], events.AskWhy(dancer=7, **STAMP)),
        "/dance/blackout": (["T"], events.Blackout(on=True, **STAMP)),
        "/dance/mocap/dancer": (
            ["ss", "anna", "ember & 1"],
            events.CastMocap(performer="anna", dancer="ember & 1", **STAMP),
        ),
        "/dance/mocap/shown": (["sF", "anna", None], events.ShowMocap(performer="anna", shown=False, **STAMP)),
        "/dance/mocap/mirrored": (["s", "anna"], events.MirrorMocap(performer="anna", mirrored=True, **STAMP)),
        "/dance/mocap/place": (
            ["sffff", "anna", "1", "-2", "90", "1.5"],
            events.PlaceMocap(performer="anna", x=1.0, z=-2.0, turn=90.0, scale=1.5, **STAMP),
        ),
        "/dance/mocap/canon": (
            ["ssf", "anna", "mist", "4"],
            events.CanonMocap(performer="anna", group="mist", beats=4.0, **STAMP),
        ),
        "/dance/mocap/obstacle": (["si", "anna", "0"], events.BlockMocap(performer="anna", obstacle=False, **STAMP)),
        "/dance/mocap/attract": (
            ["sfs", "anna", "-1", "mist"],
            events.DrawMocap(performer="anna", strength=-1.0, group="mist", **STAMP),
        ),
        "/dance/takeover": ([], events.TakeOver(**STAMP)),
        "/dance/breaker/reset": (["s", "steering"], events.ResetBreaker(name="steering", **STAMP)),
        "/dance/midi/learn": (
            ["sss", "/dance/motion/larger", "ember", "scale=1"],
            events.LearnMidi(address="/dance/motion/larger", first="ember", second="scale=1", **STAMP),
        ),
        "/dance/midi/forget": (["s", "/dance/clock/tempo"], events.ForgetMidi(address="/dance/clock/tempo", **STAMP)),
        "/dance/ping": ([], None),
        "/dance/get": (["s", "/dance/clock/tempo"], None),
        "/dance/subscribe": (["sfi", "/dance/light", "30", "0"], None),
        "/dance/unsubscribe": (["i", "9"], None),
        **group_controls(),
        **scene_controls(),
        **score_controls(),
        **audience_controls(),
    }


def audience_controls():
    """Controls of the audience's phones."""
    return {
        "/dance/audience/open": (["T"], events.OpenAudience(on=True, **STAMP)),
        "/dance/audience/close": ([], events.OpenAudience(on=False, **STAMP)),
        "/dance/audience/gain": (["f", "0.25"], events.SetAudienceGain(gain=0.25, **STAMP)),
        "/dance/audience/mute": (["i", "1"], events.MuteAudience(on=True, **STAMP)),
        "/dance/audience/region": (["sf", "balcony", "2"], events.WeighRegion(name="balcony", weight=2.0, **STAMP)),
        "/dance/audience/turn": (["si", "stalls", "8"], events.GiveTurn(name="stalls", measures=8.0, **STAMP)),
        "/dance/audience/ban": (["i", "17"], events.BanPhone(number=17, on=True, **STAMP)),
        "/dance/audience/vote": (
            ["ssss", "step", "sway", "spin", "glide"],
            events.AskVote(what="step", first="sway", second="spin", third="glide", **STAMP),
        ),
        "/dance/audience/vote/drop": ([], events.DropVote(**STAMP)),
        "/dance/audience/tally": (["F"], events.ShowTally(on=False, **STAMP)),
        "/dance/audience/invite": ([], events.RenewInvitation(**STAMP)),
        "/dance/audience/shake": (["F"], events.AllowShaking(on=False, **STAMP)),
        "/dance/audience/qr": (["i", "1"], events.ShowJoinCard(on=True, **STAMP)),
    }


def clock_and_sound_controls():
    """Controls of the clock and the sound."""
    return {
        "/dance/clock/half": ([], events.ScaleTempo(factor=0.5, **STAMP)),
        "/dance/clock/double": ([], events.ScaleTempo(factor=2.0, **STAMP)),
        "/dance/clock/nudge": (["d", "-0.015"], events.Nudge(seconds=-0.015, **STAMP)),
        "/dance/clock/shift": (["f", "0.5"], events.ShiftBeats(beats=0.5, **STAMP)),
        "/dance/clock/take": ([], events.TakeRunnerUp(**STAMP)),
        "/dance/clock/hold": (["F"], events.HoldTempo(on=False, **STAMP)),
        "/dance/clock/metre": (["i", "3"], events.SetMetre(beats=3, **STAMP)),
        "/dance/clock/count_in": (["i", "2"], events.CountIn(measures=2.0, **STAMP)),
        "/dance/clock/source": (["s", "midi"], events.ChooseSource(name="midi", **STAMP)),
        "/dance/audio/restart": ([], events.RestartAudio(**STAMP)),
        "/dance/audio/device": (
            ["ss", "stage box", "5,6"],
            events.ChooseAudio(device="stage box", channels="5,6", **STAMP),
        ),
        "/dance/audio/channels": (["s", "3"], events.ChooseAudio(channels="3", **STAMP)),
        "/dance/click": (["i", "0"], events.SetClick(on=False, **STAMP)),
        **{
            f"/dance/latency/{what}": (["f", "12.5"], events.SetLatency(what=what, milliseconds=12.5, **STAMP))
            for what in ("input", "output", "display", "projector")
        },
    }


def usual_message(control):
    """A message to a control with its required arguments, and the event that these make."""
    types, words, values = "", [], []
    for argument in control.arguments:
        if argument.default is not None:
            break
        if argument.type == "bool":
            types, values = types + "T", [*values, True]
        elif argument.type == "float":
            value = struct.unpack("<f", struct.pack("<f", max(argument.minimum, min(argument.maximum, 1.5))))[0]
            types, words, values = types + "d", [*words, repr(value)], [*values, value]
        else:
            word = "1 2, 3 4" if argument.form else "wave"
            types, words, values = types + "s", [*words, word], [*values, word]
    return [types, *words], control.call(values, **STAMP)


def sent_value(row, component):
    """A value within the range of a parameter, exact in single precision."""
    if row.kind in ("switch", "choice"):
        return row.high
    low, high = max(row.low, -4.0), min(row.high, 4.0)
    return low + (high - low) * (0.5, 0.25, 0.75)[component] if low < high else float(row.low)


def parameter_controls():
    """A message to every parameter: its numbers, and where it has them a group and the length of a fade."""
    sent = {}
    for row in (*PARAMETERS, *GROUP_PARAMETERS.values(), *MOTION_PARAMETERS):
        numbers = [struct.unpack("<f", struct.pack("<f", sent_value(row, each)))[0] for each in range(row.size)]
        if row.kind == "switch":
            types, words = "i", [str(int(numbers[0]))]
        elif row.kind == "names":
            names = list(row.choices)
            other = names[min(2, len(names) - 1)]
            types, words, numbers = "s", [f"{names[0]} + {other}"], [row.choices[names[0]] + row.choices[other]]
        else:
            types, words = "d" * row.size, [repr(number) for number in numbers]
        others = {}
        if row.per_group:
            types, words, others["group"] = types + "s", [*words, "tide"], "tide"
        if row.fades:
            types, words, others["measures"] = types + "i", [*words, "2"], 2.0
        event = events.SetParameter(address=row.address, value=tuple(numbers), **others, **STAMP)
        sent[row.address] = ([types, *words], event)
    return sent


def scene_controls():
    """Controls of scenes."""
    return {
        "/dance/pass/set": (
            ["ssff", "waves", "speed", "2.5", "1"],
            events.SetPass(name="waves", parameter="speed", amount=2.5, measures=1.0, **STAMP),
        ),
        "/dance/pass": (["sii", "ink", "1", "2"], events.SetPass(name="ink", amount=1.0, measures=2.0, **STAMP)),
        "/dance/camera": (["sf", "side", "2"], events.RecallView(name="side", measures=2.0, **STAMP)),
        "/dance/camera/follow": (
            ["sfi", "tide & 1", "0.5", "2"],
            events.Accompany(whom="tide & 1", along=0.5, measures=2.0, **STAMP),
        ),
        "/dance/background": (["si", "sea", "2"], events.ShowBackground(name="sea", measures=2.0, **STAMP)),
        "/dance/spot/follow": (
            ["sifi", "tide & 1", "2", "0.5", "1"],
            events.FollowSpot(whom="tide & 1", spot=2.0, level=0.5, measures=1.0, **STAMP),
        ),
        "/dance/world": (["s", "water"], events.RecallWorld(name="water", **STAMP)),
        "/dance/look": (["s", "dusk"], events.RecallLook(name="dusk", **STAMP)),
        "/dance/scene": (["si", "finale", "0"], events.RecallScene(name="finale", measures=0.0, **STAMP)),
        "/dance/scene/store": (["s", "mine"], events.StoreScene(name="mine", **STAMP)),
        "/dance/go": (["i", "1"], events.Go(**STAMP)),
        "/dance/cue": (["s", "12.5"], events.GiveCue(name="12.5", **STAMP)),
        "/dance/standby": (["s", "finale"], events.StandBy(name="finale", **STAMP)),
        "/dance/back": ([], events.StepBack(**STAMP)),
        "/dance/panic": ([], events.Panic(**STAMP)),
        "/dance/output/fade": (["ff", "0.25", "16"], events.FadePicture(level=0.25, beats=16.0, **STAMP)),
        "/dance/output/freeze": (["i", "1"], events.FreezePicture(on=True, **STAMP)),
        "/dance/output/flashes": (["T"], events.AllowFlashes(on=True, **STAMP)),
        "/dance/output/card": (["ss", "left", "focus"], events.ShowCard(output="left", card="focus", **STAMP)),
        "/dance/picture/quality": (["i", "3"], events.HoldQuality(step=3.0, **STAMP)),
        "/dance/hold": (["T"], events.HoldShow(on=True, **STAMP)),
        "/dance/undo": ([], events.Undo(**STAMP)),
        "/dance/redo": ([], events.Redo(**STAMP)),
    }


def score_controls():
    """Controls that move the score, and signals."""
    return {
        "/dance/section": (
            ["ssi", "solo", "section", "3"],
            events.JumpTo(section="solo", when="section", measure=3, **STAMP),
        ),
        "/dance/advance": ([], events.Advance(when="section", **STAMP)),
        "/dance/hold/score": (["T"], events.HoldScore(on=True, **STAMP)),
        "/dance/practice": (["ii", "17", "24"], events.Practice(first=17, last=24, **STAMP)),
        "/dance/improvise": (["is", "1", "left"], events.Improvise(on=True, group="left", **STAMP)),
        "/dance/signal": (["sf", "hit", "0.5"], events.Signal(name="hit", value=0.5, **STAMP)),
    }


def group_controls():
    """Controls of elements and group motion, and their events."""

    def element(kind, *points, **others):
        return events.PlaceElement(kind=kind, points=points or ((0.0, 0.0),), **others, **STAMP)

    at, line = ["ff", "1.5", "-2"], ["ffii", "0", "-4", "0", "4"]
    point, ends = (1.5, -2.0), ((0.0, -4.0), (0.0, 4.0))
    drawn, corners = "-3 0, 0 -2.5, 3 0", ((-3.0, 0.0), (0.0, -2.5), (3.0, 0.0))
    return {
        "/dance/attract/line": (line, element("attract", *ends)),
        "/dance/attract/drawn": (["s", drawn], element("attract", *corners)),
        "/dance/attract/region": (["fff", "1.5", "-2", "2"], element("attract", point, radius=2.0)),
        "/dance/voice": (at, element("attract", point, measures=2.0, fair=True, drag=True)),
        "/dance/repel/line": (line, element("repel", *ends)),
        "/dance/repel/region": (["fff", "1.5", "-2", "2"], element("repel", point, radius=2.0)),
        "/dance/cross": (
            [line[0] + "ffsT", *line[1:], "1", "8", "tide & left"],
            element("cross", *ends, measures=8.0, group="tide & left", next=True),
        ),
        "/dance/flow": (line, element("flow", *ends, flow="uniform")),
        "/dance/flow/radial": (["fff", "1.5", "-2", "-1"], element("flow", point, flow="radial", strength=-1.0)),
        "/dance/flow/vortex": (at, element("flow", point, flow="vortex")),
        "/dance/flow/drawn": (["s", drawn], element("flow", *corners, flow="drawn")),
        "/dance/path": (["s", drawn], element("path", *corners)),
        "/dance/wander": ([], element("wander")),
        "/dance/flock": (["ff", "2", "8"], element("flock", strength=2.0, measures=8.0)),
        "/dance/follow": (["s", "7"], element("follow", whom="7")),
        "/dance/pursue": (["s", "tide"], element("pursue", whom="tide")),
        "/dance/evade": (["s", "tide"], element("evade", whom="tide")),
        "/dance/formation": (
            ["sfs", "star:6", "2", "ember"],
            events.Evolve(formation="star:6", measures=2.0, group="ember", **STAMP),
        ),
        "/dance/formation/define": (
            ["ss", "flower", "circle poisson"],
            events.DefineFormation(name="flower", formation="circle poisson", **STAMP),
        ),
        "/dance/travel": (["s", drawn], events.Travel(points=corners, **STAMP)),
        "/dance/pause": (["f", "2"], events.Pause(measures=2.0, **STAMP)),
        "/dance/release": ([], events.Release(**STAMP)),
        "/dance/regroup": (["ss", "1-4", "tide"], events.Regroup(dancers="1-4", group="tide", **STAMP)),
        "/dance/ripple": (
            ["fss", "2", "0 -2", "tide"],
            events.SetRipple(beats=2.0, begins="0 -2", group="tide", **STAMP),
        ),
        "/dance/enter": (["i", "3"], events.Enter(count=3.0, **STAMP)),
        "/dance/leave": (["ss", "7", "left"], events.Leave(dancers="7", gate="left", **STAMP)),
        "/dance/obstacle": (["sff", "box", "1", "2"], events.PlaceObstacle(name="box", x=1.0, z=2.0, **STAMP)),
        "/dance/wall": (["sffff", "w", "0", "1", "2", "3"], events.PlaceWall(name="w", x=0, z=1, x2=2, z2=3, **STAMP)),
        "/dance/obstacle/remove": (["s", "box"], events.RemoveObstacle(name="box", **STAMP)),
        "/dance/stage": (["ff", "8", "5.5"], events.SetStage(width=8.0, depth=5.5, **STAMP)),
        "/dance/performer": (["sff", "Ana", "1", "2"], events.Performer(name="Ana", x=1.0, z=2.0, **STAMP)),
    }
