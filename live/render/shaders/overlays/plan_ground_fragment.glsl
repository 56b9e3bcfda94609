// The ground of the plan: a dark sheet with a line for every metre, the stage's edge, and what elements do on the floor.
#include "frame.glsl"
#include "finish.glsl"

in vec2 at;
in vec3 ray;
uniform float amount;
uniform sampler2D floor_map;
out vec4 shown;

// A line where x is 0; thinner than a pixel it is fainter, too.
float line(float x, float breadth, float pixel) {
    return (1.0 - smoothstep(0.5 * breadth, 0.5 * breadth + pixel, abs(x))) * min(1.0, 6.0 * breadth / pixel);
}

void main() {
    vec3 colour = vec3(0.010, 0.012, 0.018);
    if (ray.y < -1e-3) {
        vec2 place = eye.xz - ray.xz * (eye.y / ray.y);
        float pixel = 1.2 * length(fwidth(place)) * 0.7;
        vec2 cell = abs(fract(place + 0.5) - 0.5);
        vec2 beyond = abs(place) - edge.xy;
        float off = max(beyond.x, beyond.y);
        float inside = 1.0 - smoothstep(-pixel, pixel, off);
        float far = clamp(0.06 / pixel, 0.0, 1.0);   // lines nearer than pixels would flicker
        float grid = max(line(cell.x, 0.01, pixel), line(cell.y, 0.01, pixel)) * far;
        float axes = max(line(place.x, 0.015, pixel), line(place.y, 0.015, pixel));
        colour += vec3(0.010, 0.012, 0.017) * inside;
        colour += vec3(0.020, 0.024, 0.034) * (grid * inside) + vec3(0.020, 0.024, 0.034) * (axes * inside);
        colour += vec3(0.16, 0.18, 0.22) * line(off, 0.03, pixel);
        float front = line(place.y - edge.y - 0.18, 0.05, pixel) * step(abs(place.x), edge.x);   // where the audience is
        colour += vec3(0.45, 0.30, 0.12) * front;
        colour += texture(floor_map, place / (2.0 * stage.zw) + 0.5).rgb * 1.1;
    }
    shown = vec4(compressed(colour * key_light.w), amount);
}
