#include "frame.glsl"
#include "finish.glsl"
#include "shown.glsl"

in vec4 light;
in vec2 across;
out vec4 shown;

void main() {
    if (across.y < 0.999) discard;
    float edge = abs(across.x);
    float soft = 1.0 - smoothstep(0.55, 1.0, edge);
    float sheen = 0.75 + 0.55 * square(1.0 - edge);   // silk is brightest along its middle
    shown = laid_over(light.rgb * soft * sheen, light.a * soft);
}
