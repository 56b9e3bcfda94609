import assert from "node:assert/strict";
import { test } from "node:test";
import { call, columns, launched, pads, stateOf, type Pad } from "../src/model/pads";
import type { Structure } from "../src/model/score";

const STRUCTURE: Structure = {
  revision: 1,
  groups: [{ name: "ember", dancers: 3, colour: [1, 0, 0] }, { name: "tide", dancers: 2, colour: [0, 0, 1] }],
  library: [{ name: "walk", measures: 1 }],
  score: { formation: [{ name: "Star" }], scene: [{ name: "dusk" }], cue: [{ name: "first" }] },
};
const WALK: Pad = { kind: "steps", name: "walk", words: "1 measure" };

test("columns are everybody, the groups and the selected dancers", () => {
  assert.deepEqual(columns(STRUCTURE, [1, 5]).map((one) => one.who), ["*", "ember", "tide", "1 + 5"]);
  assert.deepEqual(columns(STRUCTURE, []).map((one) => one.who), ["*", "ember", "tide"]);
});

test("formations of the show stand before shapes, each name once", () => {
  assert.deepEqual(pads(STRUCTURE, "formations").map((pad) => pad.name), ["Star", "line", "circle", "grid", "triangle", "diagonal", "spiral"]);
  assert.deepEqual(pads(STRUCTURE, "looks").map((pad) => call(pad, "*", "now", 2)), [["/dance/scene", "dusk"], ["/dance/cue", "first"]]);
});

test("a launch says when, who and how long", () => {
  assert.deepEqual(call(WALK, "ember", "measure", 4), ["/dance/step", "walk", 4, "ember"]);
  assert.deepEqual(call(WALK, "ember", "now", 4), ["/dance/now", "walk", "ember", 4]);
  assert.deepEqual(call({ kind: "formations", name: "Star", words: "" }, "*", "measure", 2), ["/dance/formation", "Star", 2, "*", true]);
  assert.deepEqual(call({ kind: "elements", name: "spread", words: "" }, "tide", "now", 8), ["/dance/spread", 8, "tide", false]);
});

test("a pad waits, runs, ends, and gives way to the next of its kind", () => {
  const all = [launched(WALK, "ember", "measure", 2, 7)];
  assert.deepEqual([7, 8, 9, 10].map((measure) => stateOf(WALK, "ember", all, measure)), ["waits", "runs", "runs", "idle"]);
  assert.equal(stateOf(WALK, "tide", all, 8), "idle");
  const turn: Pad = { ...WALK, name: "turn" };
  all.push(launched(turn, "ember", "now", 4, 9));
  assert.deepEqual([stateOf(WALK, "ember", all, 9), stateOf(turn, "ember", all, 9)], ["idle", "runs"]);
});
