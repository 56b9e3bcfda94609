// One direction of the glow's blur.
in vec2 at;
uniform sampler2D light;
uniform vec2 stride;
out vec4 shown;

void main() {
    vec3 sum = texture(light, at).rgb;
    float weights = 1.0;
    for (int i = 1; i <= TEXELS; ++i) {
        float weight = exp(-float(i * i) / 28.0) + 0.12 * exp(-float(i) / 5.0);
        sum += (texture(light, at + stride * float(i)).rgb + texture(light, at - stride * float(i)).rgb) * weight;
        weights += 2.0 * weight;
    }
    shown = vec4(sum / weights, 1.0);
}
