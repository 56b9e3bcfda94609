#include "frame.glsl"
#include "finish.glsl"
#include "shown.glsl"

in vec3 light;
out vec4 shown;

void main() {
    vec2 at = gl_PointCoord * 2.0 - 1.0;
    float far = dot(at, at);
    if (far > 1.0) discard;
    float core = exp(-far * 7.0);
    shown = laid_over(light * (core * 1.6 + 0.25 * square(1.0 - far)), 0.0);
}
