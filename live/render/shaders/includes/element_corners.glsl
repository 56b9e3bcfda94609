// Corners of all lines and regions in force.
layout(std140) uniform Corners { vec4 corners[CORNERS]; };   // x, z, way along all lines [m], 1 / square of the piece that follows
