// Mean luminance of each cell of a picture, and how red it is where that red is saturated, from 12 x 12 of its pixels.
uniform sampler2D picture;
uniform vec2 cells;
out vec2 measured;

const int EACH = 12;

void main() {
    ivec2 size = textureSize(picture, 0);
    vec2 corner = floor(gl_FragCoord.xy) / cells;
    vec2 sum = vec2(0.0);
    for (int y = 0; y < EACH; ++y)
        for (int x = 0; x < EACH; ++x) {
            vec2 at = corner + (vec2(x, y) + 0.5) / (float(EACH) * cells);
            vec3 colour = texelFetch(picture, ivec2(at * vec2(size)), 0).rgb;
            vec3 light = pow(colour, vec3(2.2));
            float red = light.r >= 0.8 * (light.r + light.g + light.b) ? max(light.r - light.g - light.b, 0.0) : 0.0;
            sum += vec2(dot(light, vec3(0.2126, 0.7152, 0.0722)), red);
        }
    measured = sum / float(EACH * EACH);
}
