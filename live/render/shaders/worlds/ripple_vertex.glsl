// A ring on the floor: a strip around where a foot came down, as wide as its waves.
#include "frame.glsl"
in vec4 in_ring;   // x, z [m], age [beats], strength

out vec2 off;      // from its middle [m]
flat out vec3 ring;   // radius [m], strength now, its waves' length [m]

void main() {
    float age = in_ring.z, radius = 0.10 + 0.58 * age - 0.05 * age * age;
    float left = max(1.0 - age / 2.5, 0.0);
    ring = vec3(radius, in_ring.w * left * left * smoothstep(0.0, 0.2, age) , 0.20 + 0.05 * age);
    float side = float(gl_VertexID & 1), turn = 6.28318531 * float(gl_VertexID >> 1) / float(SEGMENTS);
    float far = side > 0.5 ? radius + 0.30 : max(radius - 0.42, 0.0);
    off = far * vec2(cos(turn), sin(turn)) * (side > 0.5 ? 1.01 : 1.0);   // a polygon's sides cut its circle
    gl_Position = vec4((in_ring.xy + off) / stage.zw, 0.0, 1.0);
}
