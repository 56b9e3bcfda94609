import assert from "node:assert/strict";
import { test } from "node:test";
import { beatNow, extentOf, poseAt, type Motion } from "../src/model/figure";
import { formationEdits, freeName, simplified, usesOf, withPattern, withShape } from "../src/model/formations";
import { alongWay, fillEntry, freeBefore, gapEdits, gapOf, keysOf, linkedAlso } from "../src/model/gap";
import { allBoxes } from "../src/model/plan";
import type { Structure } from "../src/model/score";
import { chainsOf, directionInWords, isWanted, takesEdit, turnInWords, written, type StepFacts } from "../src/model/steps";

const SCORE = {
  formation: [{ name: "Gate", shape: "arc", size: [5, 3] }, { name: "gate 2", shape: "line" }],
  group: [{ name: "ember", dancers: 3, formation: "gate" }],
  segment: [
    { measure: 1, measures: 2, formation: "gate" },
    { measure: 7, measures: 2, formation: "star", match: "equal", headings_deg: [1], facing: "declared" },
    { measure: 3, measures: 2, path: [[0, 0], [1, 1]] },
    { measure: 9, measures: 2, formation: "gate", group: "ember" },
  ],
};
const STRUCTURE: Structure = { revision: 1, groups: [{ name: "ember", dancers: 3, colour: [1, 0, 0] }], library: [], score: SCORE };
const pick = (...numbers: number[]) => numbers.map((number) => ({ list: "segment", number }));

function motion(): Motion {
  const rows = new Float32Array(3 * 66);
  for (let sample = 0; sample < 3; sample++) for (let joint = 0; joint < 22; joint++) rows.set([sample, 1, 0], sample * 66 + 3 * joint);
  return { beats: 2, samplesPerBeat: 1, samples: { tick: 1, count: 3, chosen: false, rows }, contact: [3, 1, 2] };
}

test("a pose lies between its samples and the step begins again", () => {
  assert.equal(poseAt(motion(), 0.5)[0], 0.5);
  assert.equal(poseAt(motion(), 2.25)[0], 0.25);
  assert.equal(poseAt(motion(), -0.5)[0], 1.5);
});

test("what a motion takes up follows its hips, or holds them", () => {
  const { left, right } = extentOf(motion(), "front", false);
  const still = extentOf(motion(), "front", true);
  assert.ok(right - left > 2 && still.right - still.left < 0.5);
});

test("the beat runs on between two clocks, and stands when they end", () => {
  const clock = { measure: 3, beat: 2, bpm: 120 } as never;
  assert.equal(beatNow(clock, 1000, 1500, 4), 10);
  assert.equal(beatNow(clock, 1000, 9000, 4), beatNow(clock, 1000, 2000, 4));
  assert.ok(beatNow(null, 0, 60_000, 4) > 100);
});

test("steps in words", () => {
  assert.deepEqual(["", "quarter turn left", "half turn right", "1 turn left", "2 turns right"], [20, 90, -180, 360, -720].map(turnInWords));
  const take = (direction: string) => ({ direction, style: "", author: "" });
  assert.equal(directionInWords({ takes: [take("in place"), take("long left"), take("short left")] } as unknown as StepFacts), "in place, left");
  assert.deepEqual(written(["walk", "walk", "turn", "walk"]), ["walk x2", "turn", "walk"]);
  assert.ok(isWanted({ name: "side step", takes: [take("long left")] as never }, "left STEP"));
  assert.ok(!isWanted({ name: "side step" }, "walk"));
});

test("uses of a formation are those of segments and groups, whatever the capitals", () => {
  assert.deepEqual(usesOf(SCORE, "GATE"), { segments: [1, 4], groups: ["ember"] });
  assert.equal(freeName(SCORE, "Gate"), "Gate 3");
  assert.equal(freeName(SCORE, "new"), "new");
});

test("a formation is saved by what changed, a new name by a rename", () => {
  assert.deepEqual(formationEdits(SCORE, 1, { name: "door", shape: "arc", arc_deg: 90 }), [
    { do: "rename", at: ["formation", 1], value: "door" },
    { do: "change", at: ["formation", 1], value: { size: null, arc_deg: 90 } },
  ]);
  assert.deepEqual(formationEdits(SCORE, 0, { name: "x" }), [{ do: "insert", at: ["formation"], value: { name: "x" } }]);
  assert.deepEqual(formationEdits(SCORE, 1, SCORE.formation[0] as object as never), []);
});

test("another shape or pattern leaves no key that it has no use for", () => {
  assert.deepEqual(withShape({ name: "a", shape: "star", corners: 6, inner: 0.3, size: [3, 3] }, "polygon"), { name: "a", shape: "polygon", corners: 6, size: [3, 3] });
  assert.deepEqual(withShape({ shape: "polyline", points: [[[0, 0], [1, 1]], [[2, 2]]], closed: true, size: [2, 2] }, "places"), { shape: "places", points: [[0, 0], [1, 1], [2, 2]] });
  assert.deepEqual(withPattern({ shape: "circle", weights: [1, 2], pattern: "weighted" }, "inside", "poisson"), { shape: "circle", dancers: "inside", pattern: "poisson" });
  assert.deepEqual(withPattern({ shape: "circle", dancers: "inside", density: 2 }, "on", "even"), { shape: "circle" });
});

test("a stroke keeps its corners", () => {
  const line = Array.from({ length: 21 }, (_, index): [number, number] => (index <= 10 ? [index / 10, 0.01 * (index % 2)] : [1, (index - 10) / 10]));
  assert.deepEqual(simplified(line), [[0, 0], [1, 0], [1, 1]]);
});

test("a gap lies between two formations of the same dancers", () => {
  const boxes = allBoxes(STRUCTURE);
  const gap = gapOf(boxes, pick(2, 1));
  assert.deepEqual(gap && [gap.free, gap.start, gap.length, gap.to, gap.formation, gap.after], [true, 2, 4, 2, "star", "gate"]);
  assert.equal(gapOf(boxes, pick(2))?.free, false);
  const single = gapOf(boxes, pick(2));
  const before = single && freeBefore(boxes, single);
  assert.deepEqual(before && [before.free, before.start, before.length, before.after], [true, 4, 2, "travel"]);
  assert.equal(gap && freeBefore(boxes, gap), null);
  assert.equal(gapOf(boxes, pick(3)), null);
  assert.equal(gapOf(boxes, pick(1, 4)), null);
  assert.equal(gapOf(boxes, pick(1, 2, 4)), null);
  assert.equal(gapOf(boxes, [...pick(1), { list: "at", number: 1 }]), null);
});

test("a choice is one edit, and what is usual is not written", () => {
  const boxes = allBoxes(STRUCTURE);
  const gap = gapOf(boxes, pick(1, 2));
  assert.ok(gap);
  assert.deepEqual(fillEntry(gap, { measure: 3 }, { match: "shortest", way: "mended" }), { measure: 3, measures: 4, formation: "star", match: "shortest" });
  assert.deepEqual(keysOf({ match: "squared" }, SCORE.segment[1] as never), { match: null, facing: null, headings_deg: null });
  const own = gapOf(boxes, pick(2));
  assert.ok(own);
  assert.deepEqual(gapEdits(own, { measure: 7 }, SCORE.segment[1] as never, { match: "equal", way: "straight", facing: "declared", headings_deg: [1] }, null), [
    { do: "change", at: ["segment", 2], value: { match: "equal", way: "straight", facing: "declared", headings_deg: [1] } },
  ]);
  const linked = gapEdits(gap, { measure: 3 }, {}, { match: "equal" }, { name: "star linked", table: { shape: "places", points: [[0, 0]] } });
  assert.deepEqual(linked.map((one) => [one.do, one.at[0]]), [["insert", "formation"], ["insert", "segment"]]);
  assert.deepEqual((linked[1] as { value: { match: string; formation: string } }).value.match, "number");
});

test("linked dancers exchange their places", () => {
  assert.deepEqual(linkedAlso([0, 1, 2], 0, 2), [2, 1, 0]);
  assert.deepEqual(alongWay([[0, 0], [2, 0], [2, 2]], 0.75), [2, 1]);
  assert.deepEqual(alongWay([[1, 1]], 0.5), [1, 1]);
});

test("sequences that touch are one chain, those of others and random ones are not", () => {
  const sequence = (measure: number, steps: string[], more = {}) => ({ measure, steps, ...more });
  const score = { sequence: [
    sequence(5, ["turn"], { group: "Ember" }), sequence(3, ["walk x2"], { group: "ember" }), sequence(5, ["bow"]), sequence(9, ["jump"], { group: "ember" }),
    sequence(6, ["walk", "turn"], { group: "ember", choose: "random" }), sequence(20, ["walk x65"]),
  ] };
  const library = ["walk", "turn", "bow", "jump"].map((name) => ({ name, measures: 1 }));
  assert.deepEqual(chainsOf(allBoxes({ ...STRUCTURE, library, score })), [
    { group: "ember", start: 2, words: ["walk x2", "turn"] }, { group: "*", start: 4, words: ["bow"] }, { group: "ember", start: 8, words: ["jump"] },
  ]);
});

test("takes are chosen by name, one stays, and all need no list", () => {
  const take = (name: string, mirrored = false) => ({ take: name, mirrored }) as never;
  const facts = { name: "walk", takes: [take("walk"), take("walk", true), take("walk, textured 1"), take("walk, textured 2")] } as never;
  assert.deepEqual(takesEdit(facts, undefined, "walk", false), { do: "set", at: ["takes", "walk"], value: ["walk, textured 1", "walk, textured 2"] });
  assert.deepEqual(takesEdit(facts, ["walk, textured 1"], "walk, textured 2", true), { do: "set", at: ["takes", "walk"], value: ["walk, textured 1", "walk, textured 2"] });
  assert.deepEqual(takesEdit(facts, ["walk", "walk, textured 1"], "walk, textured 2", true), { do: "set", at: ["takes", "walk"], value: null });
  assert.equal(takesEdit(facts, ["walk"], "walk", false), null);
});
