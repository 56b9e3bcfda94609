"""Kinds of a show other than its dancers: score, groups, cues, desk, audience, edits."""

from typing import Final

from live.show.audience.audience import Audience
from live.show.audience.audience import Place as AudiencePlace
from live.show.audience.voting import Turn, Vote
from live.show.circuit_breakers import Breakers, Stage
from live.show.dancers.step_requests import Directions
from live.show.desk.camera_rig import CameraRig, Chase, Spots
from live.show.desk.cue_list import Cues, _Given
from live.show.desk.light_desk import Desk, Master
from live.show.desk.parameters import Parameters
from live.show.desk.refusals import Refusals
from live.show.desk.scenes import Scene, Scenes
from live.show.desk.undo_history import (
    EditedFacings,
    EditedFormations,
    EditedMocap,
    EditedParameters,
    EditedRipples,
    EditedScenes,
    EditedSequences,
    EditedSet,
    EditedStandBy,
    Edits,
    _Edit,
)
from live.show.group.formations import Formations, NamedFormation
from live.show.group.group_commands import GroupControls
from live.show.group.stage_area import Floor
from live.show.measure_span import MeasureSpan
from live.show.partner.partner_pairs import Asked as AnswerPairsAsked
from live.show.partner.partner_pairs import Pair
from live.show.patch.patch_update import Reloading
from live.show.patch.section_motion import Facing
from live.show.score.beat_scheduler import Agenda
from live.show.score.canon import Echo
from live.show.score.improviser import ImprovisedMotion, Improviser
from live.show.score.music_reactions import Mood, Occasions, Reactions
from live.show.score.part import Part
from live.show.score.playhead import Asked as PlacesAsked
from live.show.score.playhead import Place as PlacesPlace
from live.show.score.playhead import Playhead, Stand, Stretch
from live.show.score.score import Score
from live.show.score.score_runner import Prompter
from live.show.score.step_history import Ledger
from live.show.score.step_program import GroupProgramme, _Before, _Call, _Place
from live.show.selection.drawn_paths import DrawnWay
from live.show.selection.graph_update import NewSteps
from live.show.show import Show
from live.show.state.kind import Kind, nothing
from live.show.view.view_builder import Seen


def _outside() -> int:
    """Return the number of no stage, because none runs between ticks."""
    return int(Stage.OUTSIDE)


KINDS: Final = [
    Kind("agenda", Agenda, """
        _heap:list[tuple[float,int,float,event]] _order:int _before:float _tick:float fired:int late_ticks_max:int
        late:int dropped:int
    """),
    Kind("answer-pairs.asked", AnswerPairsAsked, """
        name:str leader:str follower:str on:bool amount:float window:float place:str|none hands:float
    """),
    Kind("answer-pairs.pair", Pair, "partner:int leader:int follower:int own_place:bool"),
    Kind("audience", Audience, """
        _seed:int regions:row[str] _vote_measures:int open:bool gain:float muted:bool shaking:bool weights:list[float]
        turn:turn|none vote:vote|none result:tuple[int,str] banned:dict[int,none] order:int phones:int _votes:int
        _share:float _places:row[audience.place] _shaken:bool _number:i8 _lit:b1 _goal:f4 _light:f4
    """),
    Kind("audience.place", AudiencePlace, "x:float z:float weight:float repels:bool"),
    Kind("camera-rig", CameraRig, "_parameters:parameters _beats:int start:str chase:chase"),
    Kind("chase", Chase, "_motion:group-motion whom:str _who:b1|none _centre:f8 _speed:f8 running:bool"),
    Kind("show", Show, """
        patch:constant-patch graph:constant-motion-graph seed:int follower:timeline-follower _known:bool
        timeline:timeline casting:casting group:i4(group) reactions:reactions prompter:prompter motion:group-motion
        variation:variation dancers:dancers answers:constant-answer-bank scheduler:scheduler interrupts:interrupts
        _controls:group-controls span:measure-span mocap:mocap desk:desk audience:audience blackout:bool
        brightness:float time:float refusals:refusals directions:directions _seen:seen _new_steps:new-steps
        reloading:reloading breakers:breakers _beat:float _beats_per_tick:float
    """),
    Kind("breakers", Breakers, "why:dict[str,str] _level:dict[int,int]", anew={"running": _outside, "_page": nothing}),
    Kind("cues", Cues, """
        _cues:row[constant-cue-section] _playhead:playhead _beats:int standby:int last:int fired:int bounced:int
        _given:list[cues.given] late_ticks_max:int _before:float _tick:float _pressed:dict[str,float] _ways:row[any]
    """),
    Kind("cues.given", _Given, "index:int due:float earliest:float back:event|none"),
    Kind("desk", Desk, """
        parameters:parameters rig:camera-rig spots:spots energy:float scenes:scenes _prompter:prompter cues:cues
        edits:edits beats:int master:master held:bool
    """),
    Kind("directions", Directions, """
        _group:i4(group) _groups:dict[str,int] _dancers:dancers _variation:variation _scheduler:scheduler
        _interrupts:interrupts _refusals:refusals asked:int|none
    """),
    Kind("drawn-way", DrawnWay, """
        rows:list[int] _points:list[tuple[float,float]] _gone:int _next:dict[int,int] _beside:dict[int,f8*]
        _waited:float
    """),
    Kind("echo", Echo, """
        _leader:group-programme _own:group-programme _later:int _free:bool
        _said:ordered[int,tuple[int,row[wanted],int]] travel_step:int|none steps:list[int] coming:row[wanted] into:int
    """),
    Kind("edited-facings", EditedFacings, "_headings:headings"),
    Kind("edited-formations", EditedFormations, "_motion:group-motion"),
    Kind("edited-mocap", EditedMocap, "_mocap:mocap"),
    Kind("edited-parameters", EditedParameters, "_parameters:parameters"),
    Kind("edited-ripples", EditedRipples, "_variation:variation"),
    Kind("edited-scenes", EditedScenes, "_scenes:scenes"),
    Kind("edited-sequences", EditedSequences, "_scheduler:scheduler"),
    Kind("edited-set", EditedSet, "_surroundings:surroundings"),
    Kind("edited-stand-by", EditedStandBy, "_cues:cues"),
    Kind("edits", Edits, """
        _parts:dict[str,edited-facings|edited-formations|edited-mocap|edited-parameters|edited-ripples|edited-scenes|edited-sequences|edited-set|edited-stand-by]
        _done:deque[edits.edit] _undone:list[edits.edit] _before:dict[any,any]|f8|none
    """),
    Kind("edits.edit", _Edit, "words:str part:str before:dict[any,any] after:dict[any,any] key:row[str] time:float"),
    Kind("floor", Floor, "_patch:f8 half:f8 border:f8 _from:f8 _began:float _ends:float"),
    Kind("formations", Formations, """
        _seed:int _named:dict[str,named-formation] _written:dict[str,named-formation]
        _said:ordered[str,named-formation] _half:f8|none
    """),
    Kind("named-formation", NamedFormation, """
        name:str spec:formation-spec seed:int _made:ordered[int,places] half:f8|none
    """),
    Kind("group-controls", GroupControls, """
        _patch:constant-patch _motion:group-motion _dancers:dancers _variation:variation _score:score
        _joining:dict[int,int]
    """),
    Kind("improvised-motion", ImprovisedMotion, """
        _score:score _seed:int _tables:list[tuple[int,int,int,int|none,constant-improvise-section]]
    """),
    Kind("improviser", Improviser, """
        _tables:list[constant-table] _usual:constant-table _score:score _ledger:ledger _mood:mood _group:int _seed:int
        _graph:constant-motion-graph kept:tuple[int,int,int] asked:bool
    """),
    Kind("ledger", Ledger, "kept:int _of:list[ordered[int,tuple[int,int]]]"),
    Kind("master", Master, """
        level:float frozen:bool flashes:bool goal:float cards:dict[str,str] _from:float _length:float _passed:float
    """),
    Kind("measure-span", MeasureSpan, "number:int end:float _beats:float _anchor_beat:float _anchor_fraction:float"),
    Kind("mood", Mood, "_values:dict[str,float] _heard:bool notes:event-NotesHeard|none"),
    Kind("new-steps", NewSteps, "_refusals:refusals", anew={"_offered": dict, "_reserve": dict, "_next": nothing}),
    Kind("occasions", Occasions, "_signals:list[constant-signal-section] _there:list[bool]"),
    Kind("parameters", Parameters, """
        table:constant-parameter-table _variation:variation value:f8 _heard:list[variety]|none _numbers:f8 start:f8
        _from:f8 _goal:f8 _began:f8 _length:f8 _fading:b1 _running:int _ticks:int beat:float held:bool touched:bool
    """),
    Kind("part", Part, "_score:score _sequences:constant-sequences _improviser:improviser"),
    Kind("places.asked", PlacesAsked, "section:int|none measure:int at_section:bool leave:bool"),
    Kind("places.place", PlacesPlace, "section:int measure:int turn:int"),
    Kind("stand", Stand, "place:places.place passes:int begun:row[int] entered:bool jumped:bool"),
    Kind("stretch", Stretch, "name:str measures:int|none repeat:int then:int"),
    Kind("playhead", Playhead, """
        stretches:row[stretch] measure:int held:bool practice:tuple[int,int]|none _asked:places.asked
        _stands:dict[int,stand] _firsts:list[int]
    """),
    Kind("group-programme", GroupProgramme, """
        _graph:constant-motion-graph _seed:tuple[int,int] _random:bool steps:list[int] travel_step:int|none
        _own:list[wanted] _live:list[wanted] _asked:tuple[int,int]|none _place:programme.place
        _before:programme.before|none coming:row[wanted] into:int part:part|none stands:bool
    """),
    Kind("programme.before", _Before, "asked:tuple[int,int]|none place:programme.place kept:tuple[int,int,int]|none"),
    Kind("programme.call", _Call, "step:int left:int done:int"),
    Kind("programme.place", _Place, "drawn:int drawn_left:int slot:int into:int call:programme.call|none"),
    Kind("prompter", Prompter, """
        playhead:playhead score:score agenda:agenda mood:mood signals:counter[str] last_signal:str
        _given:list[constant-at-section] _reactions:reactions _occasions:occasions _motion:improvised-motion
        _known:set[str] late_jumps:int said:str said_measure:int _beats:int _names:dict[str,int]
    """),
    Kind("reactions", Reactions, """
        _follows:list[constant-react-section] _calls:list[constant-react-section] _values:list[float|none]
        _waiting:list[constant-react-section] soon:list[constant-react-section] calm:bool _building:bool
        _last:event-MusicHeard|none strength:float drops:int
    """),
    Kind("refusals", Refusals, "count:int words:str"),
    Kind("reloading", Reloading, """
        _refusals:refusals _tried:int|none version:str taken:int last:row[str]
    """, anew={"_offered": dict, "spent": list, "waiting": nothing}),
    Kind("scene", Scene, "name:str goals:dict[int,float] measures:float whom:str|none"),
    Kind("scenes", Scenes, """
        _parameters:parameters _rig:camera-rig _own:dict[str,constant-own-number] stored:dict[str,scene]
        _views:dict[str,scene] _looks:dict[str,scene] _backgrounds:list[str] _scenes:dict[str,scene]
    """),
    Kind("score", Score, "playhead:playhead _sections:dict[str,int] written:constant-written"),
    Kind("facing", Facing, "kind:str degrees:float dancer:int name:str"),
    Kind("seen", Seen, """
        _dancers:dancers _motion:group-motion _group:i4(group) _desk:desk _audience:audience _still:stage-view|none
    """),
    Kind("spots", Spots, "_parameters:parameters _chases:row[chase] _levels:list[int]"),
    Kind("turn", Turn, "region:int begins:int ends:int"),
    Kind("vote", Vote, "number:int what:str choices:row[str] closes:int counts:row[int]"),
]  # fmt: skip
