// Softens the steps along edges: blends along the edge that the brightness of the neighbours shows (after FXAA,
// Lottes 2009). Runs only on pixels that show a dancer.
#include "frame.glsl"
in vec2 at;
uniform sampler2D drawn;
uniform float crisp;   // how much finer detail is lifted, for a picture that will be stretched
out vec4 shown;

#if HDR
float bright(vec3 c) { return sqrt(dot(c, vec3(0.30, 0.59, 0.11))); }   // as bright as it will be shown, nearly
#else
float bright(vec3 c) { return dot(c, vec3(0.30, 0.59, 0.11)); }
#endif

void main() {
    vec2 texel = picture.zw;
    vec3 here = texture(drawn, at).rgb;
    float middle = bright(here);
    vec3 a = texture(drawn, at + texel * vec2(-0.5, 0.5)).rgb, b = texture(drawn, at + texel * vec2(0.5, 0.5)).rgb;
    vec3 c = texture(drawn, at + texel * vec2(-0.5, -0.5)).rgb, d = texture(drawn, at + texel * vec2(0.5, -0.5)).rgb;
    float nw = bright(a), ne = bright(b), sw = bright(c), se = bright(d);
    float least = min(middle, min(min(nw, ne), min(sw, se)));
    float most = max(middle, max(max(nw, ne), max(sw, se)));
    vec2 along = vec2((sw + se) - (nw + ne), (nw + sw) - (ne + se));
    float damp = max((nw + ne + sw + se) * 0.03, 1.0 / 128.0);
    along = clamp(along / (min(abs(along.x), abs(along.y)) + damp), -6.0, 6.0) * texel;
    vec3 close = 0.5 * (texture(drawn, at - along / 6.0).rgb + texture(drawn, at + along / 6.0).rgb);
    vec3 wide = 0.5 * close + 0.25 * (texture(drawn, at - along * 0.5).rgb + texture(drawn, at + along * 0.5).rgb);
    float reached = bright(wide);
    vec3 softened = reached < least || reached > most ? close : wide;
    vec3 smooth_ = most - least < 0.03 ? here : softened;
    vec3 lowest = min(here, min(min(a, b), min(c, d))), highest = max(here, max(max(a, b), max(c, d)));
    vec3 lifted = smooth_ + crisp * (smooth_ - 0.25 * (a + b + c + d));
    shown = vec4(crisp > 0.0 ? clamp(lifted, lowest, highest) : smooth_, 1.0);
}
