// What is brighter than the film shows well, at a quarter of the size.
#include "frame.glsl"
#include "finish.glsl"
in vec2 at;
uniform sampler2D light;
out vec4 shown;

void main() {
    vec3 sum = texture(light, at + vec2(-picture.z, -picture.w)).rgb + texture(light, at + vec2(picture.z, -picture.w)).rgb
             + texture(light, at + vec2(-picture.z, picture.w)).rgb + texture(light, at + picture.zw).rgb;
    sum = expanded(sum * 0.25);
    float most = max(sum.r, max(sum.g, sum.b));
    shown = vec4(sum * (max(most - 0.45, 0.0) / max(most, 1e-4)), 1.0);
}
