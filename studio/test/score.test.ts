import assert from "node:assert/strict";
import { test } from "node:test";
import { applyChange, type Structure } from "../src/model/score";
import { grown, hasEnd, planRows, sectionSpans, sequenceLength } from "../src/model/plan";

const STRUCTURE: Structure = {
  revision: 4,
  groups: [{ name: "ember", dancers: 3, colour: [1, 0, 0] }, { name: "tide", dancers: 2, colour: [0, 0, 1] }],
  library: [{ name: "walk", measures: 1 }, { name: "mambo", measures: 2 }],
  score: {
    clock: { beats_per_measure: 4 },
    section: [{ name: "verse", measures: 8 }, { name: "chorus", measures: 4, repeat: 2 }],
    segment: [
      { measure: 2, measures: 2, formation: "line", section: "verse" },
      { measure: 1, formation: "star", section: "chorus", group: "Ember" },
      { measure: 3, measures: 2, formation: "grid", section: "chorus", group: "ember & left" },
    ],
    sequence: [{ measure: 3, section: "verse", group: "tide", steps: ["walk x2", "mambo"] }],
  },
};

const change = (more: object): never => ({ kind: "change", revision: 5, what: "edit", by: "", of: null, edit: null, shifts: [], entries: [], ...more }) as never;

test("changes give the next structure and leave the former one as it was", () => {
  const after = applyChange(STRUCTURE, change({
    shifts: [{ list: "segment", from: null, to: 1 }, { list: "segment", from: 3, to: null }],
    entries: [{ at: ["segment", 1], value: { measure: 1, formation: "new" } }, { at: ["stage"], value: { width: 12 } }],
  }));
  assert.deepEqual((after?.score["segment"] as { formation: string }[]).map((one) => one.formation), ["new", "line", "grid"]);
  assert.deepEqual(after?.score["stage"], { width: 12 });
  assert.equal((STRUCTURE.score["segment"] as unknown[]).length, 3);
  assert.equal(applyChange(STRUCTURE, change({ revision: 6 })), null);
  assert.equal(applyChange(STRUCTURE, change({ entries: null })), null);
});

test("a list without entries is gone", () => {
  const after = applyChange(STRUCTURE, change({ shifts: [{ list: "sequence", from: 1, to: null }] }));
  assert.equal(after?.score["sequence"], undefined);
});

test("a moved entry takes its values along", () => {
  const after = applyChange(STRUCTURE, change({ shifts: [{ list: "segment", from: 1, to: 3 }] }));
  assert.deepEqual((after?.score["segment"] as { formation: string }[]).map((one) => one.formation), ["star", "grid", "line"]);
});

test("sections lie in a row, entries within theirs", () => {
  assert.deepEqual(sectionSpans(STRUCTURE.score).map((span) => [span.first, span.measures]), [[0, 8], [8, 4]]);
  const rows = planRows(STRUCTURE, "motion");
  assert.deepEqual(rows.map((row) => [row.id, row.depth]), [["signals", 0], ["calls", 0], ["all", 0], ["group 0", 0], ["part ember & left", 1], ["group 1", 0]]);
  assert.deepEqual(rows.flatMap((row) => row.boxes.map((box) => [box.label, box.start, box.length])), [["line", 1, 2], ["star", 8, 4], ["grid", 10, 2]]);
});

test("a score without an end grows with the playhead, seldom", () => {
  assert.equal(hasEnd(STRUCTURE.score), true);
  assert.equal(hasEnd({ loop_measures: 8 }), true);
  assert.equal(hasEnd({ segment: [{ measure: 2 }] }), false);
  assert.deepEqual([null, 3, 11, 12, 13, 27, 29].map((at) => grown(16, at)), [16, 16, 16, 16, 32, 32, 48]);
  assert.equal(grown(100, 20), 100);
});

test("a sequence lasts as long as its steps", () => {
  const library = new Map([["walk", 1], ["mambo", 2]]);
  assert.equal(sequenceLength(["walk x2", "Mambo x3, walk"], library), 9);
  assert.deepEqual(planRows(STRUCTURE, "steps").find((row) => row.id === "group 1")?.boxes.map((box) => [box.start, box.length]), [[2, 4]]);
});
