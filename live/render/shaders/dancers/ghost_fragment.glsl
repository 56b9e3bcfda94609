#include "frame.glsl"
#include "finish.glsl"
#include "shown.glsl"

in vec3 place;
in vec3 normal;
flat in vec4 light;
out vec4 shown;

void main() {
    float facing = abs(dot(normalize(normal), normalize(eye.xyz - place)));
    float shell = 0.10 + 0.75 * pow(1.0 - facing, 2.2);
    shown = laid_over(light.rgb * (light.a * shell), light.a * 0.10);
}
