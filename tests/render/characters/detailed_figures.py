"""Generated characters with fingers, eyes, jaw, hair that swings and blend shapes, named as several programs do."""

from dataclasses import dataclass, field

import numpy as np

from live.base.body.expression import FINGERS
from live.motion import quaternion
from live.motion.skeleton import SKELETON
from tests.render.characters.figures import Figure, document, glb, mixamo, rigify, unreal

REST = {name: place.astype(float) for name, place in zip(SKELETON.names, SKELETON.rest_positions(), strict=True)}
KNUCKLES = {
    "Thumb": ((0.035, -0.008, 0.028), (0.6, -0.1, 0.75), (0.035, 0.03, 0.027)),
    "Index": ((0.098, 0.0, 0.026), (1.0, 0.0, 0.05), (0.04, 0.026, 0.02)),
    "Middle": ((0.100, 0.002, 0.003), (1.0, 0.0, 0.0), (0.044, 0.029, 0.021)),
    "Ring": ((0.097, 0.0, -0.018), (1.0, 0.0, -0.05), (0.04, 0.026, 0.02)),
    "Little": ((0.09, -0.003, -0.037), (1.0, 0.0, -0.1), (0.032, 0.02, 0.018)),
}
"""Of a left hand: knuckle relative to the wrist [m], direction, lengths of the phalanges [m]."""
EYE = np.array([0.032, 1.60, 0.085])
HAIR_TOP = np.array([0.0, 1.63, -0.075])
HAIR_BONES, HAIR_BONE = 6, 0.07
RADIUS = 0.009


def vrm_1_finger(side, finger, bone):
    parts = ("Metacarpal", "Proximal", "Distal") if finger == "Thumb" else ("Proximal", "Intermediate", "Distal")
    return side + finger + parts[bone - 1]


def vrm_0_finger(side, finger, bone):
    return side + finger + ("Proximal", "Intermediate", "Distal")[bone - 1]


def mixamo_finger(side, finger, bone):
    return f"mixamorig:{side.capitalize()}Hand{finger.replace('Little', 'Pinky')}{bone}"


def ready_player_me_finger(side, finger, bone):
    return mixamo_finger(side, finger, bone).removeprefix("mixamorig:")


def ready_player_me(name):
    return mixamo(name).removeprefix("mixamorig:")


def makehuman(name):
    side = next((side for side in ("left", "right") if name.startswith(side)), "")
    words = {
        "hips": "root", "spine": "spine05", "chest": "spine03", "upperChest": "spine01", "neck": "neck01",
        "head": "head", "Shoulder": "clavicle", "UpperArm": "upperarm01", "LowerArm": "lowerarm01", "Hand": "wrist",
        "UpperLeg": "upperleg01", "LowerLeg": "lowerleg01", "Foot": "foot", "Toes": "toe1-1",
    }  # fmt: skip
    return words[name.removeprefix(side)] + (f".{side[0].upper()}" if side else "")


def makehuman_finger(side, finger, bone):
    return f"finger{FINGERS.index(finger) + 1}-{bone}.{side[0].upper()}"


def unreal_finger(side, finger, bone):
    return f"{finger.replace('Little', 'Pinky').lower()}_{bone:02d}_{side[0]}"


def rigify_finger(side, finger, bone):
    word = "thumb" if finger == "Thumb" else f"f_{finger.replace('Little', 'Pinky').lower()}"
    return f"DEF-{word}.{bone:02d}.{side[0].upper()}"


def biped_finger(side, finger, bone):
    number = FINGERS.index(finger)
    return f"Bip001 {side[0].upper()} Finger{number}{'' if bone == 1 else bone - 1}"


def nameless_finger(side, finger, bone):
    return f"b{side[0]}{'qwxyz'[FINGERS.index(finger)]}{bone}"


@dataclass
class Detailed(Figure):
    """Options of a detailed character."""

    finger: object = vrm_1_finger
    fingers: tuple = FINGERS
    eyes: tuple = ("leftEye", "rightEye")
    """Names of the bones of the eyes; empty: none."""
    jaw: str = ""
    hair: str = "hair"
    """Stem of the names of the bones of a ponytail; empty: none."""
    strands: int = 1
    springs: str = ""
    """`1.0` or `0.x`: springs of a VRM; else bones are found by name."""
    spring: dict = field(default_factory=dict)
    """Parameters of the springs as in VRM 1.0."""
    colliders: tuple = ()
    """Spheres on the head, as (offset, radius)."""
    shapes: dict = field(default_factory=dict)
    """Blend shapes of the face's mesh by name: functions of (position, normal) to movements."""
    expressions: dict = field(default_factory=dict)
    """VRM presets: name to {blend shape: weight}."""


class _Builder:
    def __init__(self, figure):
        self.figure = figure
        self.root, chunk = document(figure)
        self.chunk = bytearray(chunk)
        half = np.radians(figure.turn)
        self.axes = np.array([[np.cos(half), 0, np.sin(half)], [0, 1, 0], [-np.sin(half), 0, np.cos(half)]])
        self.places = {}
        self.parent = {}

    def world(self, point, carrier):
        """A point of the rest pose where the figure has it: arms may hang, it may be turned and in other units."""
        point = np.asarray(point, float)
        side = next((side for side in ("left", "right") if carrier.startswith(side)), "")
        if side and self.figure.arms_down and carrier.endswith("Hand"):
            way = -1.0 if side == "left" else 1.0
            turn = quaternion.from_axis_angle(np.array([0, 0, way]), np.radians(self.figure.arms_down))
            arm = REST[side + "UpperArm"]
            point = arm + quaternion.rotate(turn, point - arm)
        return point @ self.axes.T * self.figure.unit

    def add(self, array, kind, component):
        views, accessors = self.root["bufferViews"], self.root["accessors"]
        views.append({"buffer": 0, "byteOffset": len(self.chunk), "byteLength": array.nbytes})
        self.chunk.extend(np.ascontiguousarray(array).tobytes())
        self.chunk.extend(bytes(-len(self.chunk) % 4))
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind})
        return len(accessors) - 1

    def node(self, name, point, parent, carrier):
        """Add a node at a world point; `parent`: a node's number."""
        number = len(self.root["nodes"])
        self.places[number] = self.world(point, carrier)
        above = self.places[parent] if parent in self.places else self.joint_place(parent)
        offset = self.places[number] - above
        self.root["nodes"].append({"name": name, "translation": [float(x) for x in offset]})
        self.root["nodes"][parent].setdefault("children", []).append(number)
        return number

    def joint_place(self, node):
        place, at = np.zeros(3), node
        while at is not None:
            place = place + self.root["nodes"][at]["translation"]
            at = next((n for n, each in enumerate(self.root["nodes"]) if at in each.get("children", ())), None)
        return place

    def joint(self, name):
        """The node of a joint of the skeleton."""
        wanted = self.figure.names(name)
        return next(n for n, node in enumerate(self.root["nodes"]) if node["name"] == wanted)

    def mesh(self, name, position, normal, triangle, joints, weights, carrier, shapes=None):
        """Add a mesh skinned to the nodes `joints` (V, 4) with `weights`."""
        nodes = sorted(set(joints.ravel().tolist()))
        place = {node: number for number, node in enumerate(nodes)}
        moved = np.array([self.world(p, c) for p, c in zip(position, carrier, strict=True)])
        origin = np.array([self.world(np.zeros(3), c) for c in carrier])
        turned = np.array([self.world(n, c) for n, c in zip(normal, carrier, strict=True)]) - origin
        turned /= np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-9)
        binds = np.tile(np.eye(4), (len(nodes), 1, 1))
        binds[:, :3, 3] = [-(self.places[n] if n in self.places else self.joint_place(n)) for n in nodes]
        attributes = {
            "POSITION": self.add(moved.astype(np.float32), "VEC3", 5126),
            "NORMAL": self.add(turned.astype(np.float32), "VEC3", 5126),
            "JOINTS_0": self.add(np.vectorize(place.get)(joints).astype(np.uint8), "VEC4", 5121),
            "WEIGHTS_0": self.add(weights.astype(np.float32), "VEC4", 5126),
        }
        indices = self.add(triangle.astype(np.uint32).reshape(-1, 1), "SCALAR", 5125)
        inverse = self.add(binds.transpose(0, 2, 1).reshape(-1, 16).astype(np.float32), "MAT4", 5126)
        primitive = {"attributes": attributes, "indices": indices, "material": 0}
        mesh = {"name": name, "primitives": [primitive]}
        if shapes:
            moves = [shape(position, normal) @ self.axes.T * self.figure.unit for shape in shapes.values()]
            primitive["targets"] = [{"POSITION": self.add(move.astype(np.float32), "VEC3", 5126)} for move in moves]
            mesh["extras"] = {"targetNames": list(shapes)}
        self.root["skins"].append({"joints": nodes, "inverseBindMatrices": inverse})
        self.root["meshes"].append(mesh)
        holder = len(self.root["nodes"])
        self.root["nodes"].append(
            {"name": name, "mesh": len(self.root["meshes"]) - 1, "skin": len(self.root["skins"]) - 1}
        )
        self.root["scenes"][0]["nodes"].append(holder)
        return len(self.root["meshes"]) - 1


def tube(points, radius, sides=8, per=3):
    """Vertices, normals, triangles, place along the points (V,) of a closed tube."""
    points = np.asarray(points, float)
    along = np.linspace(0.0, len(points) - 1.0, (len(points) - 1) * per + 1)
    at = np.minimum(along.astype(int), len(points) - 2)
    middle = points[at] + (along - at)[:, None] * (points[at + 1] - points[at])
    way = points[-1] - points[0]
    way = way / np.linalg.norm(way)
    side = np.cross(way, (0.3, 0.2, 1.0))
    side /= np.linalg.norm(side)
    up = np.cross(way, side)
    angle = np.arange(sides) * (2.0 * np.pi / sides)
    ring = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * up
    size = np.full(len(along), radius)
    size[-1] *= 0.5
    position = (middle[:, None] + size[:, None, None] * ring).reshape(-1, 3)
    normal = np.tile(ring, (len(along), 1))
    triangle = []
    for row in range(len(along) - 1):
        for column in range(sides):
            a, b = row * sides + column, row * sides + (column + 1) % sides
            triangle += [(a, b, a + sides), (b, b + sides, a + sides)]
    ends = len(position)
    position = np.vstack([position, middle[[0, -1]]])
    normal = np.vstack([normal, [-way, way]])
    last = (len(along) - 1) * sides
    for column in range(sides):
        following = (column + 1) % sides
        triangle += [(ends, following, column), (ends + 1, last + column, last + following)]
    return position, normal, np.array(triangle), np.concatenate([np.repeat(along, sides), [0.0, len(points) - 1.0]])


def ball(middle, radius, rows=8, columns=12):
    """Vertices, normals and triangles of a sphere."""
    tilt, turn = np.meshgrid(np.linspace(0, np.pi, rows), np.arange(columns) * (2 * np.pi / columns), indexing="ij")
    normal = np.stack([np.sin(tilt) * np.sin(turn), np.cos(tilt), np.sin(tilt) * np.cos(turn)], axis=-1).reshape(-1, 3)
    triangle = []
    for row in range(rows - 1):
        for column in range(columns):
            a, b = row * columns + column, row * columns + (column + 1) % columns
            triangle += [(a, a + columns, b), (b, a + columns, b + columns)]
    return middle + radius * normal, normal, np.array(triangle)


def _weights(along, bones):
    """Joints and weights (V, 4) of a tube whose bone n is between its points n and n + 1, blended at the joints."""
    joints, weights = np.zeros((len(along), 4), int), np.zeros((len(along), 4))
    for vertex, at in enumerate(along):
        bone = min(int(at + 1e-9), len(bones) - 1)
        at_joint = abs(at - round(at)) < 1e-6 and 0 < round(at) < len(bones)
        joints[vertex] = bones[bone]
        weights[vertex, 0] = 1.0
        if at_joint:
            joints[vertex, 1], weights[vertex, :2] = bones[round(at) - 1], 0.5
    return joints, weights


def detailed_document(figure):
    """The JSON and the binary chunk of a detailed figure, and its added nodes by what they are."""
    build, nodes = _Builder(figure), {}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for finger in figure.fingers:
            start, way, lengths = (np.asarray(each) for each in KNUCKLES[finger])
            flip = np.array([sign, 1.0, 1.0])
            way = way / np.linalg.norm(way)
            ends = np.concatenate([[0.0], np.cumsum(lengths)])
            points = REST[side + "Hand"] + (start + ends[:, None] * way) * flip
            parent, bones = build.joint(side + "Hand"), []
            for bone in range(1, 4):
                parent = build.node(figure.finger(side, finger, bone), points[bone - 1], parent, side + "Hand")
                bones.append(parent)
            nodes |= {f"{side}{finger}{n}": node for n, node in enumerate(bones, start=1)}
            position, normal, triangle, along = tube(points, RADIUS)
            joints, weights = _weights(along, bones)
            build.mesh(f"{side}{finger}", position, normal, triangle, joints, weights, [side + "Hand"] * len(position))
    head = build.joint("head")
    for name, sign in zip(figure.eyes, (1.0, -1.0), strict=False):
        middle = EYE * (sign, 1.0, 1.0)
        node = build.node(name, middle, head, "head")
        nodes["leftEye" if sign > 0 else "rightEye"] = node
        _ball(build, name, middle, 0.013, node)
    if figure.jaw:
        nodes["jaw"] = build.node(figure.jaw, (0.0, 1.575, 0.02), head, "head")
        _ball(build, "chin", np.array([0.0, 1.535, 0.085]), 0.02, nodes["jaw"])
    if figure.shapes:
        _face(build, head)
    nodes["hair"] = _hair(build, head) if figure.hair else []
    _extensions(build, nodes)
    return build.root | {"buffers": [{"byteLength": len(build.chunk)}]}, bytes(build.chunk), nodes


def _ball(build, name, middle, radius, node):
    position, normal, triangle = ball(middle, radius)
    joints, weights = np.full((len(position), 4), node), np.tile((1.0, 0.0, 0.0, 0.0), (len(position), 1))
    build.mesh(name, position, normal, triangle, joints, weights, ["head"] * len(position))


def _face(build, head):
    position, normal, triangle = ball(np.array([0.0, 1.59, 0.02]), 0.098, rows=24, columns=32)
    joints, weights = np.full((len(position), 4), head), np.tile((1.0, 0.0, 0.0, 0.0), (len(position), 1))
    carrier = ["head"] * len(position)
    build.face = build.mesh("Face", position, normal, triangle, joints, weights, carrier, build.figure.shapes)


def _hair(build, head):
    figure, strands = build.figure, []
    for strand in range(figure.strands):
        angle = 0.0 if figure.strands == 1 else np.pi * (strand / (figure.strands - 1) - 0.5)
        top = HAIR_TOP * (1.0, 1.0, np.cos(angle)) + np.array([0.085 * np.sin(angle), 0.0, 0.0])
        step = np.array([0.12 * np.sin(angle), -1.0, -0.35 * np.cos(angle)])
        step = HAIR_BONE * step / np.linalg.norm(step)
        points = top + np.arange(HAIR_BONES + 1)[:, None] * step
        parent, bones = head, []
        for bone in range(HAIR_BONES + 1):
            parent = build.node(f"{figure.hair}_{strand}_{bone}", points[bone], parent, "head")
            bones.append(parent)
        position, normal, triangle, along = tube(points, 0.018, per=2)
        joints, weights = _weights(along, bones[:-1])
        build.mesh(f"strand {strand}", position, normal, triangle, joints, weights, ["head"] * len(position))
        strands.append(bones)
    return strands


def _extensions(build, nodes):
    figure, root = build.figure, build.root
    extensions = root.get("extensions", {})
    fingers = [(s, f, b) for s in ("left", "right") for f in figure.fingers for b in (1, 2, 3)]
    if figure.vrm == "1.0":
        vrm = extensions["VRMC_vrm"]
        bones = vrm["humanoid"]["humanBones"]
        bones |= {vrm_1_finger(s, f, b): {"node": nodes[f"{s}{f}{b}"]} for s, f, b in fingers}
        bones |= {name: {"node": nodes[name]} for name in ("leftEye", "rightEye", "jaw") if name in nodes}
        holder = next((n for n, node in enumerate(root["nodes"]) if node["name"] == "Face"), 0)
        vrm["expressions"] = {"preset": {
            name: {"morphTargetBinds": [
                {"node": holder, "index": list(figure.shapes).index(shape), "weight": weight}
                for shape, weight in binds.items()
            ]} for name, binds in figure.expressions.items()
        }}  # fmt: skip
    elif figure.vrm:
        vrm = extensions["VRM"]
        vrm["humanoid"]["humanBones"] += [
            {"bone": vrm_0_finger(s, f, b), "node": nodes[f"{s}{f}{b}"]} for s, f, b in fingers
        ]
        vrm["blendShapeMaster"] = {"blendShapeGroups": [
            {"name": name, "presetName": name, "binds": [
                {"mesh": build.face, "index": list(figure.shapes).index(shape), "weight": 100.0 * weight}
                for shape, weight in binds.items()
            ]} for name, binds in figure.expressions.items()
        ]}  # fmt: skip
    if figure.springs == "1.0":
        colliders = [
            {"node": build.joint("head"), "shape": {"sphere": {"offset": list(offset), "radius": radius}}}
            for offset, radius in figure.colliders
        ]
        extensions["VRMC_springBone"] = {
            "specVersion": "1.0", "colliders": colliders,
            "colliderGroups": [{"name": "head", "colliders": list(range(len(colliders)))}],
            "springs": [
                {"name": f"strand {n}", "joints": [{"node": node, **figure.spring} for node in strand],
                 "colliderGroups": [0] if colliders else []}
                for n, strand in enumerate(nodes["hair"])
            ],
        }  # fmt: skip
    elif figure.springs == "0.x":
        spring = figure.spring
        x, y, z = spring.get("gravityDir", (0.0, -1.0, 0.0))
        extensions["VRM"]["secondaryAnimation"] = {
            "colliderGroups": [{"node": build.joint("head"), "colliders": [
                {"offset": {"x": x0, "y": y0, "z": -z0}, "radius": radius} for (x0, y0, z0), radius in figure.colliders
            ]}],
            "boneGroups": [{
                "stiffiness": spring.get("stiffness", 1.0), "gravityPower": spring.get("gravityPower", 0.0),
                "gravityDir": {"x": x, "y": y, "z": z}, "dragForce": spring.get("dragForce", 0.5),
                "hitRadius": spring.get("hitRadius", 0.02), "center": -1,
                "bones": [strand[0] for strand in nodes["hair"]], "colliderGroups": [0],
            }],
        }  # fmt: skip
    if extensions:
        root["extensions"], root["extensionsUsed"] = extensions, list(extensions)


def detailed_glb(**wanted):
    """The GLB file of a detailed figure."""
    root, chunk, _ = detailed_document(Detailed(**wanted))
    return glb(root, chunk)


def _bump(middle, radius, move):
    """A blend shape that moves what lies around a point by `move`."""

    def shape(position, _):
        near = np.clip(1.0 - np.linalg.norm(position - np.asarray(middle), axis=1) / radius, 0.0, 1.0)
        return near[:, None] * np.asarray(move)

    return shape


ARKIT = {
    "eyeBlinkLeft": _bump((0.035, 1.62, 0.11), 0.03, (0.0, -0.012, 0.0)),
    "eyeBlinkRight": _bump((-0.035, 1.62, 0.11), 0.03, (0.0, -0.012, 0.0)),
    "jawOpen": _bump((0.0, 1.54, 0.10), 0.05, (0.0, -0.03, -0.005)),
    "mouthSmileLeft": _bump((0.03, 1.555, 0.105), 0.03, (0.008, 0.010, 0.0)),
    "mouthSmileRight": _bump((-0.03, 1.555, 0.105), 0.03, (-0.008, 0.010, 0.0)),
    "browInnerUp": _bump((0.0, 1.645, 0.10), 0.035, (0.0, 0.010, 0.002)),
    "tongueOut": _bump((0.0, 1.55, 0.11), 0.02, (0.0, 0.0, 0.02)),
}
STYLES = {
    "VRM 1.0": {"vrm": "1.0", "finger": lambda s, f, b: f"J_Bip_{s[0].upper()}_{f}{b}"},
    "VRM 0.x": {"vrm": "0.x", "turn": 180.0, "finger": lambda s, f, b: f"J_Bip_{s[0].upper()}_{f}{b}"},
    "Mixamo": {"names": mixamo, "finger": mixamo_finger, "unit": 100.0,
               "eyes": ("mixamorig:LeftEye", "mixamorig:RightEye")},
    "Ready Player Me": {"names": ready_player_me, "finger": ready_player_me_finger, "eyes": ("LeftEye", "RightEye"),
                        "arms_down": 45.0},
    "MakeHuman": {"names": makehuman, "finger": makehuman_finger, "eyes": ("eye.L", "eye.R"), "jaw": "jaw",
                  "arms_down": 40.0, "unit": 0.1},
    "game engine": {"names": unreal, "finger": unreal_finger, "eyes": ()},
    "Rigify": {"names": rigify, "finger": rigify_finger, "eyes": ("DEF-eye.L", "DEF-eye.R"), "jaw": "DEF-jaw"},
    "nothing said": {"names": lambda name: f"n{SKELETON.names.index(name)}", "finger": nameless_finger, "eyes": (),
                     "hair": "z"},
    "Biped fingers": {"names": unreal, "finger": biped_finger, "eyes": ()},
}  # fmt: skip
"""How several programs name the bones."""
