// A garment of a dancer, lit now or later, plain or in a style.
#include "frame.glsl"
#include "garment.glsl"
#if STYLED
#define VERTEX 1
#include "surface.glsl"
#include "styles.glsl"
flat out ivec2 own;      // dancer, group
#endif

uniform float nearer;    // [m]

out vec3 place;
out vec4 facing;         // normal, openness
out vec4 body;           // place on the flat cloth, 16 times the dancer; in a style 0

invariant gl_Position;   // drawn twice where the processor draws: depth, then light

void main() {
    Worn here = worn();
    place = here.place;
    facing = vec4(here.normal, 0.9);
    body = vec4(on_cloth(), 16 * in_worn.x);
#if STYLED
    body.w = 0.0;
    own = ivec2(in_worn.x, group_of(who(in_worn.x)));
#endif
    gl_Position = seen_at(place, nearer);
}
