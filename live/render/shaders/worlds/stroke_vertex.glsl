// A fine line of light between two places, or a point: a quad along it that faces the camera.
#include "frame.glsl"
#include "surface.glsl"
#include "styles.glsl"

in vec3 in_begin;
in vec3 in_end;
in vec3 in_stroke;    // dancer, brightness, radius [m]
uniform int mirrored; // 1: in the floor

out vec3 across;      // places along and across it and its length, in radii of its glow
flat out vec4 light;

void main() {
    float flip = mirrored == 1 ? -1.0 : 1.0, side = float(gl_VertexID & 1) * 2.0 - 1.0, end = float(gl_VertexID >> 1);
    vec4 a = world_to_clip * vec4(in_begin.x, flip * in_begin.y, in_begin.z, 1.0);
    vec4 b = world_to_clip * vec4(in_end.x, flip * in_end.y, in_end.z, 1.0);
    float scale = ray_corner.w;
    vec4 at = end < 0.5 ? a : b;
    float pixel = whole_picture.y / 720.0, wide = in_stroke.z * 2.6 * scale / at.w, reach = max(wide, 1.6 * pixel);
    vec2 pa = a.xy / a.w * picture.xy * 0.5, pb = b.xy / b.w * picture.xy * 0.5;
    float long_ = length(pb - pa);
    bool point = in_begin == in_end;
    vec2 way = !point && long_ > 1e-3 ? (pb - pa) / long_ : vec2(1.0, 0.0);
    float tip = end * 2.0 - 1.0;
    at.xy += (way * tip + vec2(-way.y, way.x) * side) * reach * 2.0 * picture.zw * at.w;
    across = vec3(end * (point ? 0.0 : long_) / reach + tip, side, (point ? 0.0 : long_) / reach);
    int dancer = int(in_stroke.x + 0.5);
    vec3 glow = glow_of(dancer);
    float beat = point ? 0.8 + 0.6 * key_direction.w : 0.9 + 0.2 * key_direction.w;
    float height = 0.5 * (in_begin.y + in_end.y);
    float seen = mirrored == 1 ? 0.30 * exp(-max(height, 0.0) * 0.9) : 1.0;
    light = vec4(mix(glow, vec3(0.80, 0.90, 1.0), point ? 0.30 : 0.22), in_stroke.y * beat * seen * min(wide / reach + 0.25, 1.0));
    gl_Position = min(a.w, b.w) > 0.05 ? at : vec4(2.0, 2.0, 2.0, 1.0);
}
