// A packet of waves across a ring: slopes and height.
in vec2 off;
flat in vec3 ring;
out vec4 shown;

void main() {
    float far = length(off), x = (far - ring.x) / ring.z;
    float bell = exp(-x * x * 0.9) * ring.y, wave = 6.28318531 * x;
    float height = cos(wave) * bell;
    float slope = -sin(wave) * bell;
    shown = vec4(off / max(far, 0.02) * slope, height, 1.0);
}
