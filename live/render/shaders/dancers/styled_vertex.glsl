// A dancer whose body is drawn in a style.
#include "frame.glsl"
#include "skin.glsl"
#include "surface.glsl"
#include "styles.glsl"

in float in_openness;

out vec3 place;
out vec4 facing;         // normal, openness
out vec4 body;           // place in the rest pose, dancer
flat out ivec2 own;      // dancer, group

invariant gl_Position;   // drawn twice where the processor draws: depth, then light

void main() {
    Skinned skin = skinned(in_position, in_normal);
    place = skin.place;
    facing = vec4(skin.normal, in_openness);
    body = vec4(in_position, in_dancer);
    own = ivec2(int(in_dancer), group_of(who(int(in_dancer))));
    gl_Position = world_to_clip * vec4(place, 1.0);
}
