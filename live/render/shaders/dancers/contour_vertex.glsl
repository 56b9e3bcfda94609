// The body's back, swollen by the breadth of the pen: what is seen of it around her is the line.
#include "frame.glsl"
#include "skinned.glsl"
#include "surface.glsl"
#include "styles.glsl"

flat out vec4 ink;

invariant gl_Position;   // drawn twice where the processor draws: depth, then light

void main() {
    Skinned skin = skinned();
    int group = group_of(who(in_instance.x));
    float amount = amounts(group).z;
    vec4 at = world_to_clip * vec4(skin.place, 1.0);
    vec2 aside = clip_way(world_to_clip * vec4(skin.normal, 0.0)) * picture.xy;
    float pen = style_ink_width(group) * whole_picture.y / 1080.0 * smoothstep(0.0, 1.0, amount);
    // far away a pen as broad as near would fill the body
    pen *= clamp(9.0 / at.w, 0.45, 1.6);
    at.xy += normalize(aside + vec2(1e-6)) * max(pen, 0.001) * 2.0 * picture.zw * at.w;
    at.z += 0.0008 * at.w;
    gl_Position = at;
    ink = vec4(style_ink_colour(group) * (2.0 * answer(group)), amount);
}
