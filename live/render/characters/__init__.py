"""Users' own characters: glTF, GLB and VRM models brought onto the engine's skeleton, drawn in the place of bodies."""
