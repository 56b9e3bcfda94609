// What spreads over each pixel, gathered on a spiral of equal areas: what is behind a sharp edge does not cover it
// (after Gustafsson 2018, Bokeh depth of field in a single pass). Where all is sharp nothing is gathered.
in vec2 at;
uniform sampler2D spread;
uniform sampler2D tiles;
uniform float tile;
out vec4 shown;           // light, how much of it lies before the focus and spreads over what is sharp

const float GOLDEN = 2.39996323;

void main() {
    vec2 pixel = 1.0 / vec2(textureSize(spread, 0));
    vec4 here = texelFetch(spread, ivec2(gl_FragCoord.xy), 0);
    float reach = texelFetch(tiles, ivec2(gl_FragCoord.xy / tile), 0).r;
    int taps = reach < 0.4 ? 0 : TAPS;
    float own = abs(here.a), total = 1.0, front = here.a < 0.0 ? 1.0 : 0.0;
    vec3 sum = here.rgb;
    // four neighbours take places between each other's; focus_fragment.glsl averages them
    ivec2 odd = ivec2(gl_FragCoord.xy) & 1;
    float between = 0.25 * float(odd.x + 2 * (odd.x ^ odd.y)) + 0.125;
    for (int i = 0; i < taps; ++i) {
        float radius = reach * sqrt((float(i) + between) / float(TAPS));
        float angle = GOLDEN * (float(i) + between);
        vec4 there = textureLod(spread, at + pixel * radius * vec2(cos(angle), sin(angle)), 0.0);
        float size = abs(there.a);
        if (there.a > here.a) size = min(size, max(2.0 * own, 0.0));   // what is behind stays behind
        float covers = smoothstep(radius - 0.75, radius + 0.75, size) * smoothstep(0.2, 0.8, size);
        sum += mix(sum / total, there.rgb, covers);
        front += covers * step(there.a, -0.4);
        total += 1.0;
    }
    shown = vec4(sum / total, clamp(2.0 * front / total, 0.0, 1.0));
}
