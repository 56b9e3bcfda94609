#include "frame.glsl"
in vec3 in_position;
in vec3 in_normal;
in vec4 in_colour;   // square root of the colour, openness

out vec3 place;
out vec3 facing;
out vec4 colour;

void main() {
    place = in_position;
    facing = in_normal;
    colour = in_colour;
    gl_Position = world_to_clip * vec4(in_position, 1.0);
}
