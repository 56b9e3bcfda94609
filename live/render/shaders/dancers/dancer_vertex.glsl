#include "frame.glsl"
#include "skinned.glsl"

in float in_openness;
in vec4 in_rest;   // place on the usual body, part

out vec3 place;
out vec4 facing;   // normal, openness
out vec4 body;     // place on the usual body, 16 times the dancer and the part

void main() {
    Skinned skin = skinned();
    place = skin.place;
    facing = vec4(skin.normal, in_openness);
    body = vec4(in_rest.xyz, 16 * in_instance.x + int(in_rest.w + 0.5));
    gl_Position = world_to_clip * vec4(place, 1.0);
}
