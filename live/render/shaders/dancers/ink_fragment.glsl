// Lines of ink where one thing ends and another begins: by dancer, by depth, by normal.
#include "finish.glsl"
#include "ink_lines.glsl"
in vec2 at;
uniform sampler2D light;
uniform float amount;
uniform float width;          // [pixels]
uniform float paper;          // how much of the picture gives way to paper
uniform vec3 ink;
uniform vec3 paper_colour;
out vec4 shown;

void main() {
    vec3 here = expanded(texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb);
    // on paper light becomes a wash: what is dark in colour or shadow takes a little of the paper's brightness
    float bright = dot(here, vec3(0.2126, 0.7152, 0.0722));
    float wash = 0.80 + 0.20 * smoothstep(0.0, 0.25, bright);
    vec3 tint = here / max(max(here.r, max(here.g, here.b)), 1e-3);
    float body = textureLod(who, at, 0.0).a;
    vec3 sheet = paper_colour * min(key_light.w, 1.0) * mix(vec3(wash), mix(vec3(1.0), tint, 0.45) * wash, body);
    here = mix(here, sheet, paper * amount);
    vec3 drawn = mix(here, ink * min(key_light.w, 1.0), line(at, width) * amount);
    shown = vec4(compressed(drawn), 1.0);
}
