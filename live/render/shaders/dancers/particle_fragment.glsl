#include "frame.glsl"
#include "finish.glsl"
#include "shown.glsl"

in vec3 light;
in float soft;
out vec4 shown;

void main() {
    vec2 at = gl_PointCoord * 2.0 - 1.0;
    float far = dot(at, at);
    if (far > 1.0) discard;
    shown = laid_over(light * (exp(-far * 4.5) - 0.011), 0.0);
}
