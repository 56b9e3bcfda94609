// The shadow of a set piece in the floor map's layers, as shadow_fragment.glsl has it, fading with the piece.
in float height;
uniform float amount;
out vec4 layers;

void main() {
    layers = vec4(1.0 - smoothstep(0.10, 0.30, height), 1.0 - smoothstep(0.55, 0.95, height), 1.0, 1.0) * amount;
}
