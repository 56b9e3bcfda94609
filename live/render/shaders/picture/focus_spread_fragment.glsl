// A smaller picture with the radius of each pixel's circle of confusion: a thin lens (Potmesil and Chakravarty 1981).
#include "frame.glsl"
#include "finish.glsl"
#include "distance.glsl"
in vec2 at;
uniform sampler2D light;
uniform float focus;      // distance of what is sharp [m]
uniform float widest;     // radius in pixels of this picture of what is infinitely far
uniform float most;       // largest radius
uniform float apart;      // of the samples from the middle [pixels of the picture]
out vec4 spread;          // light, radius: below 0 before the focus

float radius_at(vec2 place) {
    float away = distance_at(place);
    return clamp(widest * (away - focus) / away, -most, most);
}

void main() {
    // light of what lies elsewhere in depth is left out: it would surround what is sharp with its own colour
    float own = radius_at(at);
    vec3 sum = texture(light, at).rgb * 1e-3;
    float weights = 1e-3;
    for (int i = 0; i < 4; ++i) {
        vec2 place = at + apart * picture.zw * vec2(float(i & 1) * 2.0 - 1.0, float(i >> 1) * 2.0 - 1.0);
        float weight = clamp(1.0 - abs(radius_at(place) - own), 0.0, 1.0);
        sum += texture(light, place).rgb * weight;
        weights += weight;
    }
    spread = vec4(expanded(sum / weights), own);
}
