// A point of light bound to the skin: it breathes with the beat, and some leave the skin, rise and go out. All is a
// function of the point's own numbers and the beat; nothing is simulated.
#include "frame.glsl"
#include "skin.glsl"
#include "surface.glsl"
#include "styles.glsl"

uniform float beat;       // modulo 96

in vec4 in_chance;        // place in the order of appearance, and three more, 0 to 1

out vec3 light;
out float soft;

const float TURN = 6.28318531;

void main() {
    int dancer = in_dancer;
    vec4 mine = who(dancer);
    int group = group_of(mine);
    float amount = style_particles(group);
    Skinned skin = skinned(in_position, in_normal);
    float drift = style_particles_drift(group);
    // half of the points cling, half live for two, three or four beats
    float cling = step(in_chance.y, 0.92 - 0.6 * drift);
    float lasts = 2.0 + floor(in_chance.z * 2.999);
    float age = fract(beat / lasts + in_chance.w + mine.y);
    float phase = TURN * (in_chance.w + floor(in_chance.z * 4.0) * beat / 8.0);
    vec3 sway = vec3(sin(phase + TURN * in_chance.y), 0.6 * sin(1.0 + phase), cos(phase - TURN * in_chance.z));
    float out_ = 0.004 + 0.030 * key_direction.w * (0.3 + in_chance.z) + 0.012 * drift * sway.y;
    vec3 place = skin.place + skin.normal * out_;
    float gone = (1.0 - cling) * age;
    place += skin.normal * (gone * drift * 0.22 * (0.4 + in_chance.z));
    place += sway * (gone * drift * 0.10) + vec3(0.0, gone * gone * drift * 0.42 * (0.3 + in_chance.y), 0.0);

    vec4 at = world_to_clip * vec4(place, 1.0);
    // pixels in a metre
    float scale = ray_corner.w / at.w;
    float size = scale * mix(0.0085, 0.019, in_chance.z * in_chance.z * in_chance.y) * (1.0 + 0.5 * key_direction.w);
    float bright = min(size / 1.6, 1.0);
    size = max(size, 1.6) * 2.0;
    float seen = step(in_chance.x, style_particles_share(group)) * amount;
    vec3 to_eye = normalize(eye.xyz - place);
    float facing = dot(skin.normal, to_eye);
    float shell = 0.30 + 0.70 * square(1.0 - abs(facing));
    shell *= facing < 0.0 ? 0.35 : 1.0;
    float fade = mix(smoothstep(0.0, 0.06, age) * square(1.0 - age) * 1.5, 1.0, cling);
    float spark = 0.75 + 0.5 * sin(TURN * (beat * (1.0 + floor(in_chance.y * 3.0)) + in_chance.x * 7.0));
    vec3 glow = glow_of(dancer);
    glow = mix(glow, vec3(1.0), 0.22 + 0.5 * in_chance.z * in_chance.z * in_chance.z);
    light = glow * (seen * shell * fade * spark * bright * 2.0 * answer(group) * (0.8 + 0.5 * key_direction.w));
    soft = size;
    gl_PointSize = size;
    gl_Position = seen * fade > 0.0 ? at : vec4(2.0, 2.0, 2.0, 1.0);
}
