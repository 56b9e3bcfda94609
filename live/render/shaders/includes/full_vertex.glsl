// One triangle over the whole picture; no buffers.
#include "frame.glsl"

out vec2 at;
out vec3 ray;
#ifdef OWN
uniform vec4 own_part_;   // shares of the picture that is drawn, and where it begins
#endif

void main() {
    at = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : 0.0);
    ray = ray_corner.xyz + ray_right.xyz * at.x + ray_up.xyz * at.y;
    gl_Position = vec4(at * 2.0 - 1.0, 1.0, 1.0);
#ifdef OWN
    at = at * own_part_.xy + own_part_.zw;
#endif
}
