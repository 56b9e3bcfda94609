// What does not change while camera and light stand still: all that is behind the dancers in one world. Drawn once, kept.
#include "frame.glsl"
#include "noise.glsl"

in vec2 at;
in vec3 ray;
uniform float share;   // of this world
out vec4 kept;         // rgb: square root of light, a: how much of it a shadow on the floor takes away

// Square roots, so that the eye sees half of each world in the middle of a fade, and not the brighter one alone.
void keep(vec3 light, float shade) { kept = vec4(sqrt(max(light, 0.0)), shade) * share; }

// Colours of the dark and of the floor. While worlds fade into each other so do these; a dark world takes no more of a
// bright one's than it can bear, or it would be bright until the end of the fade. Alone it takes any.
vec3 own(vec3 colour, float most) { return min(colour, mix(vec3(most), colour, smoothstep(0.96, 1.0, share))); }
vec3 own_background(float most) { return own(light_background(), most); }
vec3 own_floor(float most) { return own(light_floor(), most); }

// Where the ray meets the floor [m along it]; far away if it does not.
float floor_reach(vec3 direction) { return direction.y < -1e-4 ? -eye.y / direction.y : 1e4; }
