// What a pass of somebody's own has: see `live docs passes`. Its text follows, then own_footer.glsl.
in vec2 at;
uniform sampler2D own_light_;
uniform sampler2D own_last_;
uniform sampler2D own_depth_;
uniform sampler2D own_shape_;
uniform sampler2D own_who_;
uniform vec4 own_part_;
uniform float amount;    // how much of the pass is seen, 0 to 1
uniform float beat;      // beats of the show; comes back after 4096
uniform float phase;     // beats into the measure
uniform float measure;   // number of the measure, from 1
uniform float tempo;     // [bpm]
uniform float energy;    // of the music, 0 to 1
uniform float time;      // [s]
uniform vec2 size;       // of the picture [pixels]
out vec4 own_shown_;

vec2 own_there_(vec2 at) { return (at - own_part_.zw) / own_part_.xy; }
vec3 own_out_(vec3 c) { return c / max(1.0 - max(c.r, max(c.g, c.b)), 0.02); }
// The picture so far: linear light, 1 is white paper in full light, lamps are brighter. Places go from 0, 0 (lower left) to 1, 1.
vec3 light(vec2 at) { return own_out_(textureLod(own_light_, own_there_(at), 0.0).rgb); }
// What this pass made of the picture before.
vec3 last(vec2 at) { return own_out_(textureLod(own_last_, own_there_(at), 0.0).rgb); }
// How far away a dancer is [m]; where nobody is, as far as can be seen.
float depth(vec2 at) {
    float z = textureLod(own_depth_, own_there_(at), 0.0).r * 2.0 - 1.0;
    return 2.0 * FAR * NEAR / (FAR + NEAR - z * (FAR - NEAR));
}
// Where the surface of a dancer faces, in the world: x to the right, y up, z to the audience; 0 where nobody is.
vec3 normal(vec2 at) {
    vec4 there = textureLod(own_who_, own_there_(at), 0.0);
    return there.a > 0.0 ? normalize(textureLod(own_shape_, own_there_(at), 0.0).xyz - 0.5) : vec3(0.0);
}
// Number of the dancer from 1 on; 0: nobody.
int dancer(vec2 at) {
    ivec2 there = ivec2(textureLod(own_who_, own_there_(at), 0.0).rg * 255.0 + 0.5);
    return there.x + 256 * there.y;
}
