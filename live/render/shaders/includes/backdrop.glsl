// What does not change while camera and light stand still: all that is behind the dancers in one world. Drawn once, kept.
#include "frame.glsl"
#include "noise.glsl"

in vec2 at;
in vec3 ray;
uniform float share;   // of this world
out vec4 kept;         // rgb: light, a: how much of it a shadow on the floor takes away

// Where the ray meets the floor [m along it]; far away if it does not.
float floor_reach(vec3 direction) { return direction.y < -1e-4 ? -eye.y / direction.y : 1e4; }
