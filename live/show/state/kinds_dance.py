"""Kinds of a show's dancers: plans, steps, paths, partner responses."""

from typing import Final

from live.show.background_work import Pieces
from live.show.capture.capture_manager import Mocap
from live.show.capture.performer import Captured
from live.show.capture.performer_forces import Presence
from live.show.capture.pose_buffer import Anchor, HeardPoses
from live.show.capture.stage_presence import Edges, Performers
from live.show.dancers.collision_avoidance import Avoiding, Pushing
from live.show.dancers.correction_update import Coming, ReAiming
from live.show.dancers.dancers import Dancers
from live.show.dancers.live_texture import Texturing
from live.show.dancers.measure_state import Danced, _Ends
from live.show.dancers.partners import PairSteering, Partners
from live.show.dancers.root_correction import Carried
from live.show.dancers.root_correction_control import Carrying
from live.show.dancers.timing_offsets import Drift, Ripple
from live.show.dancers.variation import Variation, Variety
from live.show.group.casting import Casting
from live.show.group.elements import Addressees, Elements
from live.show.group.evolutions import Evolutions
from live.show.group.group_motion import GroupMotion
from live.show.partner.leader_input import AnswerLeaders
from live.show.partner.partner_agents import AnsweringAgents
from live.show.partner.partner_response import Answering
from live.show.partner.response_path import TakenAlong
from live.show.partner.response_pose import AnswerPoses
from live.show.patch.background_check import Drafting
from live.show.selection.choices import Choices
from live.show.selection.clip_cut import Cutting, Moment
from live.show.selection.interrupts import Interrupts, _Cue
from live.show.selection.lookahead import AgentsAhead
from live.show.selection.planning import Planning
from live.show.selection.scheduler import Scheduler
from live.show.selection.step_search import Searching
from live.show.selection.step_targets import Aims, Headings
from live.show.state import consistency as whole
from live.show.state.kind import Kind

KINDS: Final = [
    Kind("addressees", Addressees, "_casting:casting _words:list[str|none] _lasting:list[bool] bits:u8"),
    Kind("agents-ahead", AgentsAhead, """
        _look:look-ahead _evolutions:evolutions _elements:elements _entrances:entrances _floor:floor _count:int
        _beats:int _late:f8
    """),
    Kind("aims", Aims, """
        _patch:constant-patch _dancers:dancers _motion:group-motion _programmes:list[echo|group-programme]
        _group:i4(group) order:list[int] headings:headings speed:f4 _asked:list[tuple[int|none,int]] step:i4(step)
        row:i4(aim) heading:f8 _choosing:constant-choosing foresight:constant-foresight ahead:f8 _reach:f8
    """),
    Kind("anchor", Anchor, "offset:tuple[float,float] apart:tuple[float,float] _mean:tuple[float,float]"),
    Kind("answer-leaders", AnswerLeaders, """
        _bank:constant-answer-bank read:dict[tuple[int,int],read-leader] news:list[tuple[int,str,str]] told:int
        _fresh:list[str]
    """),
    Kind("answer-poses", AnswerPoses, """
        _leaders:answer-leaders _along:taken-along standing:standing _offsets:f4 _parents:i4(joint)
    """),
    Kind("answering", Answering, """
        bank:constant-answer-bank _casting:casting _variation:variation _beats:int asked:list[answer-pairs.asked]
        pairs:list[answer-pairs.pair] leaders:answer-leaders along:taken-along live:b1 _poses:answer-poses
        holding:holding _ways:dict[int,drawn-way] _agents:f4 _danced:f8 _written:list[answer-pairs.asked]
        _roster:roster _leaving:list[answer-pairs.pair]
    """),
    Kind("answering-agents", AnsweringAgents, "_radius:f4 _usual:float _answering:answering|none"),
    Kind("avoiding", Avoiding, """
        _half_stage:f8 _dancers:dancers _motion:group-motion _sent:method _cutting:cutting _cut:method _ways:f8
        _things:f8 _tick:int _met:f8 _waiting:list[int] count:int
    """),
    Kind("captured", Captured, """
        edges:edges rows:i8(dancer)* delay:f8* share:f8* moved:f8* turned:f8* poses:heard-poses draws:float
        follower:int _spot:tuple[float,float] _target:tuple[float,float] _tracked:float anchor:anchor
        _suit:tuple[float,float] _anchored:bool section:constant-mocap-section shown:bool mirrored:bool obstacle:bool
        attract:float attracts:str dancer:str|none canon:str canon_beats:float turn:float scale:float
        origin:tuple[float,float,float]
    """, whole=whole.captured),
    Kind("carried", Carried, """
        dancers:dancers motion:group-motion paths:paths node:i4(node) rows:f8 begin:f8 end:f8 goal:f8 predicted:f8
        asked:f8 foreseen:f8 room:f8 most:f8 hasty:f8
    """),
    Kind("carrying", Carrying, """
        _patch:constant-patch _dancers:dancers _motion:group-motion parting:path-parting _carried:carried
        _coming:coming _re_aiming:re-aiming _pushing:pushing|none reference:f4 pace:f4 lag:f8 _odd:bool _slid:f8
        _stood:f8 _ended:bool _begun:bool _open:bool
    """),
    Kind("casting", Casting, """
        group:i4(group) names:row[str] half:tuple[float,float] _own:row[frozenset[str]] _named:dict[str,str]
        roster:roster
    """),
    Kind("choices", Choices, """
        edge:i4(edge) candidate:i4(candidate) terms:f8 end:f8 node:i4(node) stand:f8 heading:f8 step:i4(step) wish:f8
        target:f8 error:f8 lag:f8 behind:i4 _decided:bool
    """),
    Kind("coming", Coming, """
        _carried:carried _parting:path-parting most:float paths:paths end:f8 target:f8 wish:f8 room:f8 _traced:int
        fresh:bool _goal:f8 _plan:f8 _ease:float
    """),
    Kind("cutting", Cutting, "_dancers:dancers _joints:f8 _parents:i4(joint) cuts:int"),
    Kind("cutting.moment", Moment, """
        rows:i4 time:float dt:float fraction:float other:float body:tuple[f4,f4] which:i4 phase:f8 held:b1 feature:f8
        hips:f8 facing:f8
    """),
    Kind("danced", Danced, """
        graph:constant-motion-graph _ends:danced.ends|none decided:bool node:i4(node) placement:f8 correction:f8
        aimed:f8 on_support:f8 take:i4(node) take_share:f4 amplitude:f8 warp:f8
    """),
    Kind("danced.ends", _Ends, """
        _node:i4(node) _take:i4(node) _share:f4 _graph:constant-motion-graph hips:f8 heading:f8
    """),
    Kind("dancers", Dancers, """
        graph:constant-motion-graph variation:variation past:danced present:danced coming:danced
        _pipeline:pose-pipeline _everybody:i8(dancer) _phase:f8 lock:foot-lock hands:hands _locked_at:float
        _aside:pose-pipeline _legs:pose-pipeline inertia:inertia landing:landing texturing:texturing
        captured:dict[str,captured] beats:int answering:answering|none _settled:f4 _bare_legs:tuple[f4,f4] shown:f4
    """),
    Kind("drafting", Drafting, "_dancers:dancers _choices:choices _aims:aims draft:danced _choosing:constant-choosing"),
    Kind("drift", Drift, """
        _count:int _seed:int phase:f8 _knots:f8 _amplitude_knots:f8 _frequency_knots:f8 _drawn:tuple[int|none,f8]
        _knots_of:int|none _passes:f8|none
    """),
    Kind("edges", Edges, "_half:f8 place:f8* _time:float _floor:row[float] _mirrored:bool"),
    Kind("elements", Elements, """
        _score:score _addressees:addressees _field:element-field _ahead:f4 _last_of:dict[str,element] _placed:int
        _of_line:list[element] gain:float
    """),
    Kind("evolutions", Evolutions, """
        _patch:constant-patch _casting:casting _score:score _formations:formations _beats:int _plan:plan _added:int
        _measure:int _of_line:list[segment] _next:int _fresh:bool _heading:f8|none _ways:int
    """),
    Kind("group-motion", GroupMotion, """
        _patch:constant-patch casting:casting _seed:int _beats:int _half:f4 model:agent-model floor:floor
        gates:row[gate] entrances:entrances surroundings:surroundings performers:performers part:parting
        evolutions:evolutions elements:elements partners:partners starting_heading:f8 state:agent-state
        _spare:agent-state _advance:pair-steering wants:wants _along:answering-agents _ahead:agents-ahead
        _now:tuple[timeline,measure-span]|none _speed:f4 _leash:f4~
    """),
    Kind("headings", Headings, "_patch:constant-patch _motion:group-motion _facing:list[facing] _raw:f8 _before:f8"),
    Kind("heard-poses", HeardPoses, "count:int _gap:float _catch:float _root:f4* _turned:f4* stamp:f8*~",
         whole=whole.heard_poses),
    Kind("interrupts", Interrupts, """
        _dancers:dancers _motion:group-motion _scheduler:scheduler cutting:cutting _cues:list[interrupts.cue]
        _half:tuple[int,int]|none _decided:bool _step:i4(step) _unplanned:b1 _avoiding:avoiding cues:int
    """),
    Kind("interrupts.cue", _Cue, "step:int who:b1 measures:int groups:row[int]"),
    Kind("mocap", Mocap, """
        _patch:constant-patch _motion:group-motion _dancers:dancers _scheduler:scheduler performers:dict[str,captured]
        _led:b1 _place:f8 _speed:f8 _presence:presence _time:float
    """),
    Kind("pair-steering", PairSteering, "_advance:advance _partners:partners"),
    Kind("partners", Partners, """
        _group:i4(group) _manner:i4 _arm:f8 _holds:list[row[tuple[int,int]]] of:i4(dancer) leader:i4(dancer)*
        follower:i4(dancer)* other:i4(dancer) hand:i4(side) _meeting:b1 _own:i4(dancer) _dance:bool offset:f8
    """),
    Kind("performers", Performers, "_surroundings:surroundings _radius:float _last:dict[str,event-Performer]"),
    Kind("pieces", Pieces, "_waiting:deque[tuple[float,method]] left:float"),
    Kind("planning", Planning, """
        _dancers:dancers _motion:group-motion _group:i4(group) _aims:aims _choices:choices _drafting:drafting
        _searching:searching pieces:pieces _looked:bool
    """),
    Kind("presence", Presence, "_motion:group-motion _tick:int"),
    Kind("pushing", Pushing, "_carried:carried _coming:coming _parting:path-parting _soon:f4 _fractions:f8 count:int"),
    Kind("re-aiming", ReAiming, "_carried:carried _parting:path-parting most:float _phase:f8"),
    Kind("ripple", Ripple, "beats:float side:str point:tuple[float,float]"),
    Kind("scheduler", Scheduler, """
        _patch:constant-patch _dancers:dancers _motion:group-motion _group:i4(group)
        programmes:list[echo|group-programme] carrying:carrying aims:aims order:list[int] speed:f4 choices:choices
        _planning:planning choosing:constant-choosing foresight:constant-foresight last_target:f8|none last_heading:f8
        detours:int dead_ends:int
    """),
    Kind("searching", Searching, """
        _patch:constant-patch _dancers:dancers _motion:group-motion _aims:aims _choices:choices _asked_from:i4(node)
        _arguments:row[any] _following:tuple[i4(dancer)*,i4(dancer)*] seconds:float _choosing:constant-choosing
        _give:f8 _usual_give:float
    """),
    Kind("taken-along", TakenAlong, """
        level:f8 share:f8 following:b1 carried:b1 led:b1 seeks:b1 goal:f8 moved:f8 answered:f8 place:f8 turn:f8
        _before:f8 _amount:f8 _waited:f8 _known:b1
    """),
    Kind("texturing", Texturing, """
        bank:constant-texture-bank _variation:variation _seed:int _beats:int level:f4 fragment:i4(fragment) chosen:i8
        switched:f8 _origin:f8 _limits:i4 _signs:i8 _kept:f4 _before:f4 _now:f4 _own:f4 _far:f4 _since:f8~
        _danced_before:f8 _offsets:f4 _parents:i4(joint)
    """),
    Kind("variation", Variation, """
        _varieties:list[variety] _group:i4(group) _late:f8 _seed:int _beats:int _window:float drift:drift measure:int
        ripples:list[ripple] _written:row[variety] _rippled:row[ripple] late:f8 _late_before:f8 _like:i4(dancer)
        _liked:i4(dancer) _paired:i8(dancer)* _even:f8 _everybody:i8(dancer) warp_beats:f8 warp_sequence:f8 larger:f8
        amplitude:f8 amplitude_sequence:f8 mix:f8 arms:f8 head:f8 lock:f8 on_support:f8 face_average:f8 obedience:f8
        texture:f8 mirror:f8 _drifts:bool _farthest:f8 obeys:bool textures:bool locks:bool
    """),
    Kind("variety", Variety, """
        warp_beats:float warp_sequence:float larger:float amplitude:float amplitude_sequence:float mix:float
        arms:float head:float lock:float on_support:float face_average:float obedience:float texture:float
        mirror:float
    """),
]  # fmt: skip
