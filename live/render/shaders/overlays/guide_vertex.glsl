// One instance is one stroke: a strip along the line between two places, equally broad on the picture wherever it is.
#include "frame.glsl"
uniform float breadth;    // [pixels]

in vec3 in_begin;
in vec3 in_end;
in vec4 in_colour;

out vec4 colour;

void main() {
    vec4 begin = world_to_clip * vec4(in_begin, 1.0);
    vec4 end = world_to_clip * vec4(in_end, 1.0);
    // what lies behind the eye cannot be seen, nor divided by its distance
    bool seen = min(begin.w, end.w) > 0.05;
    vec2 along = (end.xy / end.w - begin.xy / begin.w) * picture.xy;
    vec2 aside = length(along) > 1e-4 ? normalize(vec2(-along.y, along.x)) : vec2(0.0, 1.0);
    vec4 at = (gl_VertexID & 1) == 0 ? begin : end;
    at.xy += (float(gl_VertexID >> 1) * 2.0 - 1.0) * breadth * aside * picture.zw * at.w;
    gl_Position = seen ? vec4(at.xy, 0.0, at.w) : vec4(2.0, 2.0, 2.0, 1.0);
    colour = in_colour;
}
