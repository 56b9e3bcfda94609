// A square on the floor around each dancer, turned to where she faces.
#include "frame.glsl"
in vec4 in_place;    // x, z [m], where she faces
in vec4 in_colour;

out vec2 offset;     // to her left, and where she faces [m]
flat out vec3 tint;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    vec2 facing = normalize(in_place.zw + vec2(0.0, 1e-6));
    offset = corner * 0.46;
    vec2 place = in_place.xy + offset.x * vec2(facing.y, -facing.x) + offset.y * facing;
    gl_Position = in_place.x < 1e8 ? world_to_clip * vec4(place.x, 0.0, place.y, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
    tint = in_colour.rgb;
}
