// The body as glass: it is seen where it is looked through along its skin.
#include "frame.glsl"
#include "surface.glsl"
#include "styles.glsl"
#include "finish.glsl"
#include "shown.glsl"

in vec3 place;
in vec4 facing;
in vec4 body;
flat in ivec2 own;
out vec4 shown;

void main() {
    float looked = max(dot(normalize(facing.xyz), normalize(eye.xyz - place)), 0.0);
    float rim = pow(1.0 - looked, 2.6);
    vec3 glow = mix(glow_of(own.x), vec3(0.75, 0.9, 1.0), 0.25);
    shown = laid_over(glow * (amounts(own.y).w * (0.012 + 0.50 * rim) * answer(own.y)), 0.0);
}
