// A smaller picture with the radius of each pixel's circle of confusion: a thin lens (Potmesil and Chakravarty 1981).
#include "frame.glsl"
#include "finish.glsl"
#include "distance.glsl"
in vec2 at;
uniform sampler2D light;
uniform float focus;      // distance of what is sharp [m]
uniform float widest;     // radius in pixels of this picture of what is infinitely far
uniform float most;       // largest radius
out vec4 spread;          // light, radius: below 0 before the focus

void main() {
    float away = distance_at(at);
    vec3 sum = texture(light, at + 0.5 * vec2(-picture.z, -picture.w)).rgb + texture(light, at + 0.5 * vec2(picture.z, -picture.w)).rgb
             + texture(light, at + 0.5 * vec2(-picture.z, picture.w)).rgb + texture(light, at + 0.5 * picture.zw).rgb;
    spread = vec4(expanded(sum * 0.25), clamp(widest * (away - focus) / away, -most, most));
}
