import assert from "node:assert/strict";
import { test } from "node:test";
import { copied, firstSectionEdits, groundOf, joinEdits, moveEdits, pasteEdits, phraseEdit, phrases, placeKeys, resizeEdits, snappedMove, splitEdits, unitOf } from "../src/model/arrange";
import { allBoxes, planRows } from "../src/model/plan";
import type { Structure } from "../src/model/score";

const STRUCTURE: Structure = {
  revision: 1,
  groups: [{ name: "ember", dancers: 3, colour: [1, 0, 0] }, { name: "tide", dancers: 2, colour: [0, 0, 1] }],
  library: [{ name: "walk", measures: 1 }, { name: "mambo", measures: 2 }],
  score: {
    clock: { beats_per_measure: 4 },
    section: [{ name: "verse", measures: 8, repeat: 2 }, { name: "chorus", measures: 8 }],
    segment: [
      { measure: 2, measures: 4, formation: "line", section: "verse", group: "ember" },
      { measure: 1, measures: 2, formation: "star", section: "chorus", group: "ember" },
    ],
    sequence: [{ measure: 1, section: "verse", steps: ["walk x2", "mambo", "walk"] }, { measure: 6, section: "verse", steps: ["walk"] }],
    at: [{ measure: 2, beat: 3, section: "verse", call: "/dance/go" }],
  },
};
const ground = groundOf(STRUCTURE.score, STRUCTURE.library);
const box = (list: string, number: number) => allBoxes(STRUCTURE).find((one) => one.list === list && one.number === number)!;
const same = (): null => null;

test("a box moves on its grid, into other sections and to other dancers", () => {
  assert.equal(snappedMove(box("segment", 1), 0.6, unitOf("segment", "beat", 4)), 1);
  assert.equal(snappedMove(box("at", 1), 0.2, unitOf("at", "beat", 4)), 0.25);
  assert.equal(snappedMove(box("segment", 1), -9, 1), -1);
  assert.deepEqual(moveEdits([box("segment", 1)], 8, same, false, ground), [{ do: "change", at: ["segment", 1], value: { section: "chorus" } }]);
  assert.deepEqual(moveEdits([box("at", 1)], 0.75, same, false, ground), [{ do: "change", at: ["at", 1], value: { measure: 3, beat: 2 } }]);
  assert.deepEqual(moveEdits([box("segment", 1)], 0, () => "tide", false, ground), [{ do: "change", at: ["segment", 1], value: { group: "tide" } }]);
  assert.deepEqual(moveEdits([box("segment", 1), box("segment", 2)], 1, same, true, ground).map((one) => [one.do, one.at[1]]), [["copy", 2], ["copy", 1]]);
  assert.deepEqual(moveEdits([box("segment", 1)], 0, same, false, ground), []);
});

test("edges", () => {
  assert.deepEqual(resizeEdits([box("segment", 1)], 2, "end", ground), [{ do: "resize", at: ["segment", 1], value: 6 }]);
  assert.deepEqual(resizeEdits([box("segment", 1)], 1, "begin", ground), [{ do: "change", at: ["segment", 1], value: { measure: 3, measures: 3 } }]);
  assert.deepEqual(resizeEdits([box("at", 1)], 1, "end", ground), []);
});

test("steps are split between steps only, and joined again", () => {
  const edits = splitEdits([box("sequence", 1)], 2, ground);
  assert.deepEqual(edits, [
    { do: "copy", at: ["sequence", 1], value: { measure: 3, steps: ["mambo", "walk"] } },
    { do: "set", at: ["sequence", 1, "steps"], value: ["walk x2"] },
  ]);
  assert.match(String(splitEdits([box("sequence", 1)], 3, ground)), /several measures/);
  assert.match(String(splitEdits([box("sequence", 1)], 7, ground)), /cursor/);
  assert.deepEqual(joinEdits([box("sequence", 2), box("sequence", 1)], ground), [
    { do: "change", at: ["sequence", 1], value: { steps: ["walk x2", "mambo", "walk x2"] } },
    { do: "delete", at: ["sequence", 2] },
  ]);
  assert.equal(typeof joinEdits([box("segment", 1), box("sequence", 1)], ground), "string");
});

test("what is pasted keeps its distances and gets the row's dancers", () => {
  const kept = copied([box("segment", 2), box("segment", 1)]);
  assert.deepEqual(pasteEdits(kept, 4, "tide", ground).map((one) => one.value), [
    { measures: 2, formation: "star", group: "tide", measure: 4, section: "chorus" },
    { measures: 4, formation: "line", group: "tide", measure: 5, section: "verse" },
  ]);
});

test("places, phrases and a first section", () => {
  assert.deepEqual(placeKeys("element", 9.25, ground), { measure: 2.25, section: "chorus" });
  assert.deepEqual(phrases({}, 20).map((one) => [one.start, one.measures]), [[0, 8], [8, 8], [16, 4]]);
  assert.deepEqual(phrases({ music: { phrase: [{ measure: 1, name: "A" }, { measure: 5, name: "B" }] } }, 8).map((one) => [one.name, one.measures]), [["A", 4], ["B", 4]]);
  const edits = firstSectionEdits({ loop_measures: 8, segment: [{ measure: 1 }], signal: [{ name: "loud", on: "loud" }] }, "A", 8);
  assert.deepEqual(edits.map((one) => one.at[0]), ["section", "loop_measures", "segment"]);
});

test("curves have rows of their own", () => {
  const rows = planRows({ ...STRUCTURE, score: { ...STRUCTURE.score, curve: [{ name: "light", points: [[0, 0], [4, 1]] }] } }, "motion");
  assert.deepEqual(rows.map((row) => row.id), ["signals", "curve 1", "calls", "all", "group 0", "group 1"]);
  assert.equal(rows[4]?.selection, "ember");
});

test("phrases are named, begun and taken away where they begin", () => {
  const score = { music: { phrase: [{ measure: 9, name: "B" }, { measure: 1, name: "A" }] } } as never;
  assert.deepEqual(phrases(score, 20).map((one) => [one.start, one.measures, one.name, one.number]), [[0, 8, "A", 2], [8, 12, "B", 1]]);
  assert.deepEqual(phraseEdit(score, 8, "chorus"), { do: "set", at: ["music", "phrase", 1, "name"], value: "chorus" });
  assert.deepEqual(phraseEdit(score, 8, ""), { do: "delete", at: ["music", "phrase", 1] });
  assert.equal(phraseEdit(score, 8, "B"), null);
  assert.deepEqual(phraseEdit({}, 4, "C"), { do: "insert", at: ["music", "phrase"], value: { measure: 5, name: "C" } });
  const sorted = { music: { phrase: [{ measure: 1, name: "A" }, { measure: 9, name: "B" }] } } as never;
  assert.deepEqual(phraseEdit(sorted, 4, "C"), { do: "insert", at: ["music", "phrase", 2], value: { measure: 5, name: "C" } });
  assert.deepEqual(phrases({}, 12).map((one) => [one.start, one.measures, one.number]), [[0, 8, 0], [8, 4, 0]]);
});
