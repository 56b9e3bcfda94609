// A piece of a dancer's way: instance i is the piece of age i / count of dancer i % count, broader the newer it is.
#include "frame.glsl"
uniform sampler2D places;    // column: dancer, row: when, in a ring
uniform sampler2D colours;
uniform int newest;
uniform int kept;
uniform int count;

out vec4 colour;
out float across;

void main() {
    int dancer = gl_InstanceID % count, age = gl_InstanceID / count;
    vec2 a = texelFetch(places, ivec2(dancer, (newest - age + kept) % kept), 0).xy;
    vec2 b = texelFetch(places, ivec2(dancer, (newest - age - 1 + 2 * kept) % kept), 0).xy;
    vec4 begin = world_to_clip * vec4(a.x, 0.0, a.y, 1.0), end = world_to_clip * vec4(b.x, 0.0, b.y, 1.0);
    bool seen = max(abs(a.x), abs(b.x)) < 1e8 && distance(a, b) < 2.0 && min(begin.w, end.w) > 0.05;
    vec2 along = (end.xy / end.w - begin.xy / begin.w) * picture.xy;
    vec2 aside = length(along) > 1e-4 ? normalize(vec2(-along.y, along.x)) : vec2(0.0, 1.0);
    float left = 1.0 - (float(age) + float(gl_VertexID & 1)) / float(kept);
    float breadth = max(whole_picture.y / 720.0 * mix(1.6, 5.0, left), 1.5);
    across = float(gl_VertexID >> 1) * 2.0 - 1.0;
    vec4 at = (gl_VertexID & 1) == 0 ? begin : end;
    at.xy += across * breadth * aside * picture.zw * at.w;
    gl_Position = seen ? vec4(at.xy, 0.0, at.w) : vec4(2.0, 2.0, 2.0, 1.0);
    colour = vec4(texelFetch(colours, ivec2(dancer, 0), 0).rgb, pow(left, 0.6));
}
