"""Formation tables shared by the tests."""

HEART = "M 0 3 C -5 -1 -2 -4 0 -1.5 C 2 -4 5 -1 0 3 Z"
RING = "M -3 0 A 3 3 0 1 0 3 0 A 3 3 0 1 0 -3 0 Z M -2 0 A 2 2 0 1 0 2 0 A 2 2 0 1 0 -2 0 Z"
ELL = [[0, 0], [4, 0], [4, 1.5], [1.5, 1.5], [1.5, 4], [0, 4]]
CROSS = [[[-3, 0], [3, 0]], [[0, -2], [0, 2]]]
ZIGZAG = [[[-5, -3], [-3.5, 0], [-2, -3], [0, 1.5]], [[-4.5, 2.5], [-3, 2.5], [-2, 1.5]]]

LINES = [
    {"shape": "line"},
    {"shape": "arc", "arc_deg": 250, "rotation_deg": 40},
    {"shape": "circle"},
    {"shape": "ellipse"},
    {"shape": "polygon", "corners": 3},
    {"shape": "polygon", "points": ELL, "mark_corners": False},
    {"shape": "rectangle"},
    {"shape": "star", "corners": 6},
    {"shape": "spiral"},
    {"shape": "text", "text": "LIVE 8"},
    {"shape": "path", "path": HEART},
    {"shape": "path", "path": "M -3 0 C -3 -3 3 3 3 0 C 3 -3 -3 3 -3 0 Z"},
    {"shape": "polyline", "points": CROSS},
    {"shape": "polyline", "points": ZIGZAG, "mark_corners": True},
    {"shape": "line", "weights": [1, 0, 5]},
    {"shape": "star", "focus": [0, 2]},
]
AREAS = [
    {"shape": "circle"},
    {"shape": "rectangle", "size": [9, 1.2]},
    {"shape": "star"},
    {"shape": "polygon", "points": ELL, "rotation_deg": 20},
    {"shape": "path", "path": HEART},
    {"shape": "path", "path": RING},
]
PATTERNS = [
    {"pattern": "grid"},
    {"pattern": "diagonal"},
    {"pattern": "concentric"},
    {"pattern": "poisson"},
    {"pattern": "even", "dancers": "inside"},
    {"pattern": "weighted", "dancers": "inside", "focus": [1, 1]},
]
EVERYTHING = [{"shape": "grid"}, *LINES, *({**area, **pattern} for area in AREAS for pattern in PATTERNS)]
