// A solid thing that fades leaves pixels out: it keeps its depth, so that drawing order does not matter.
uniform float amount;

void dissolve() {
    float chance = fract(52.9829189 * fract(dot(gl_FragCoord.xy + picture_part.xy, vec2(0.06711056, 0.00583715))));   // Jimenez 2014
    if (chance >= amount) discard;
}
