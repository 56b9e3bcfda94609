// A ribbon that a hand or foot has drawn: a strip that faces the camera, through where the limb was at each beat.
#include "frame.glsl"
#include "skin.glsl"
#include "surface.glsl"
#include "styles.glsl"

uniform sampler2D limbs;      // rows: samples, columns: four limbs of each dancer; xyz [m], w: 1 where she was there
uniform vec4 ring;            // newest sample, samples, beats since it, samples a beat
uniform int known;            // samples that are known
uniform ivec2 limbs_layout;   // dancers in a row, blocks
uniform float drawn_back;     // how far back it is drawn, 0 to 1: there it ends as it does at its full length

in vec4 in_strip;             // how far back, 0 to 1; side, -1 or 1; limb; unused

out vec4 light;               // premultiplied by what it hides
out vec2 across;               // side, 1 where both ends of a piece are known

vec4 sampled(int limb, int back) {   // the sample so many before the newest; -1: where the limb is now
    int dancer = in_dancer, slots = int(ring.y);
    int slot = back < 0 ? slots : (int(ring.x) - back + slots) % slots;
    ivec2 at = ivec2(dancer % limbs_layout.x * 4 + limb, slot * limbs_layout.y + dancer / limbs_layout.x);
    vec4 tip = texelFetch(limbs, at, 0);
    return vec4(tip.xyz, back < known ? tip.w : 0.0);
}

float when(int back) { return back < 0 ? 0.0 : ring.z + float(back) / ring.w; }   // beats ago

void main() {
    int dancer = in_dancer, limb = int(in_strip.z);
    int group = group_of(who(dancer));
    float ago = in_strip.x * style_ribbons_beats(group);
    int first = ago < ring.z ? -1 : min(int(floor((ago - ring.z) * ring.w)), int(ring.y) - 4);
    vec4 a = sampled(limb, max(first - 1, -1)), b = sampled(limb, first), c = sampled(limb, first + 1), d = sampled(limb, first + 2);
    float ta = when(max(first - 1, -1)), tb = when(first), tc = when(first + 1), td = when(first + 2);
    float span = max(tc - tb, 1e-4), u = clamp((ago - tb) / span, 0.0, 1.0);
    vec3 leave = (c.xyz - a.xyz) / max(tc - ta, 1e-4) * span, reach = (d.xyz - b.xyz) / max(td - tb, 1e-4) * span;
    float uu = u * u, uuu = uu * u;
    vec3 place = b.xyz * (2.0 * uuu - 3.0 * uu + 1.0) + leave * (uuu - 2.0 * uu + u) + c.xyz * (3.0 * uu - 2.0 * uuu) + reach * (uuu - uu);
    vec3 along = b.xyz * (6.0 * uu - 6.0 * u) + leave * (3.0 * uu - 4.0 * u + 1.0) + c.xyz * (6.0 * u - 6.0 * uu) + reach * (3.0 * uu - 2.0 * u);
    float fast = length(along) / span;   // metres a beat
    vec3 to_eye = eye.xyz - place;
    float away = length(to_eye);
    vec3 side = cross(along, to_eye);
    side = length(side) > 1e-5 ? normalize(side) : vec3(0.0, 1.0, 0.0);
    float left = max(1.0 - in_strip.x / drawn_back, 0.0);
    float hand = limb < 2 ? 1.0 : 0.7;
    float half_ = 0.042 * hand * (0.25 + 0.75 * left) * smoothstep(0.0, 0.05, in_strip.x) * (0.7 + 0.3 * key_direction.w);
    float thinnest = 0.7 * away / ray_corner.w;
    float faint = min(half_ / thinnest, 1.0);
    place += side * (max(half_, thinnest) * in_strip.y);
    bool there = min(min(b.w, c.w), min(a.w, d.w)) > 0.5;

    vec3 glow = glow_of(dancer);
    vec3 tint = mix(mix(glow, vec3(1.0), 0.55 * left * left), glow.brg, 0.16 * (1.0 - left));
    float strong = style_ribbons(group) * pow(left, 1.6) * faint * smoothstep(0.05, 0.7, fast) * hand;
    float lamp = 0.35 + 0.65 * abs(normalize(side).y);
    light = vec4(tint * (strong * (0.5 + 0.5 * lamp) * 0.85 * answer(group)), strong * 0.55);
    across = vec2(in_strip.y, there ? 1.0 : 0.0);
    gl_Position = world_to_clip * vec4(place, 1.0);
}
