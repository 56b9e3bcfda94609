// A dancer as she was at an earlier beat, drawn over the stage as a shell of light that fades with age.
#include "frame.glsl"
#include "skin.glsl"
#include "surface.glsl"
#include "styles.glsl"

uniform vec4 ages[PART_COUNT / 4];   // beats since the ghosts of each part of a group were left; below 0: none

out vec3 place;
out vec3 normal;
flat out vec4 light;

void main() {
    Skinned skin = skinned(in_position, in_normal);
    int dancer = in_dancer, group = group_of(who(dancer));
    float spacing = style_trails_spacing(group);
    float ago = ages[group / 4][group % 4];
    float left = 1.0 - ago / (style_trails_ghosts(group) * spacing);
    place = skin.place;
    normal = skin.normal;
    vec3 glow = glow_of(dancer);
    float strong = style_trails(group) * smoothstep(0.0, 0.25, ago / spacing) * max(left, 0.0) * (0.5 + 0.5 * left);
    // the older, the nearer to the light from behind
    vec3 cold = rim_light.rgb / max(max(rim_light.r, max(rim_light.g, rim_light.b)), 1e-3);
    vec3 tint = mix(glow, mix(cold, glow.brg, 0.25), 0.75 * (1.0 - left));
    light = vec4(tint * answer(group), strong);
    gl_Position = ago >= 0.0 && left > 0.0 ? world_to_clip * vec4(place, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
    gl_Position.z -= 2.5e-7 * gl_Position.w;   // two steps of the depth before a body that stands where it stood
}
