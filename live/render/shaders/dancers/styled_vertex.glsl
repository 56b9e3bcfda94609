// A dancer whose body is drawn in a style.
#include "frame.glsl"
#include "skinned.glsl"
#include "surface.glsl"
#include "styles.glsl"

in float in_openness;
in vec4 in_rest;         // place on the usual body, part

out vec3 place;
out vec4 facing;         // normal, openness
out vec4 body;           // place on the usual body, part
flat out ivec2 own;      // dancer, group

invariant gl_Position;   // drawn twice where the processor draws: depth, then light

void main() {
    Skinned skin = skinned();
    place = skin.place;
    facing = vec4(skin.normal, in_openness);
    body = in_rest;
    own = ivec2(in_instance.x, group_of(who(in_instance.x)));
    gl_Position = world_to_clip * vec4(place, 1.0);
}
