import assert from "node:assert/strict";
import { test } from "node:test";
import { awayInWords, columns, countOf, freePadName, launchCall, launchInWords, launchOf, measureOf, measuresAway, nextCall, nextInWords, nextOf, shareOf, type Launch, type Launches, type Pad, type WhatNext } from "../src/model/pads";
import type { Structure } from "../src/model/score";

const STRUCTURE: Structure = {
  revision: 1,
  groups: [{ name: "ember", dancers: 3, colour: [1, 0, 0] }, { name: "tide", dancers: 2, colour: [0, 0, 1] }],
  library: [{ name: "walk", measures: 1 }],
  score: {},
};
const WALK: Pad = { pad: "step walk", kind: "step", name: "walk", words: "1 measure" };
const KEPT: Pad = { pad: "own opening", kind: "step", name: "opening", words: "step walk", does: "walk", measures: 2, follow: "next" };

function told(...launches: Launch[]): Launches {
  return { beats: 4, launches, away: { ember: { walk: 2, turn: -1 } } };
}

test("columns are everybody, the groups and the selected dancers", () => {
  assert.deepEqual(columns(STRUCTURE, [1, 5]).map((one) => one.who), ["*", "ember", "tide", "1 + 5"]);
  assert.deepEqual(columns(STRUCTURE, []).map((one) => one.who), ["*", "ember", "tide"]);
});

test("a launch says who, when, how long and what follows; a kept pad has that itself", () => {
  assert.deepEqual(launchCall(WALK, "ember", "beat", 4, "again"), ["/dance/launch", "step walk", "ember", "beat", 4, "again"]);
  assert.deepEqual(launchCall(KEPT, "*", "section", 4, "again"), ["/dance/launch", "own opening", "*", "section"]);
});

test("a pad shows what waits before what runs, in its own column", () => {
  const runs: Launch = { pad: "step walk", who: "ember", state: "runs", due: 4, until: 12 };
  const waits: Launch = { ...runs, state: "waits", due: 12, until: null };
  assert.equal(launchOf(told(runs, waits), WALK, "ember"), waits);
  assert.equal(launchOf(told(runs), WALK, "Ember"), runs);
  assert.equal(launchOf(told(runs), WALK, "*"), null);
  assert.equal(launchOf(told(runs), KEPT, "ember"), null);
  const refused: Launch = { pad: "step walk", who: "ember", state: "refused", why: "no" };
  assert.equal(launchOf(told(refused), WALK, "ember"), refused);
});

test("beats are counted down to one, and measures up", () => {
  const waits: Launch = { pad: "step walk", who: "ember", state: "waits", due: 12 };
  assert.deepEqual([8, 8.5, 11, 11.5, 12.2].map((danced) => countOf(waits, danced)), [4, 4, 1, 1, 1]);
  assert.equal(countOf({ ...waits, due: null }, 8), null);
  const runs: Launch = { ...waits, state: "runs", due: 5, until: 16 };
  assert.deepEqual([5, 7.9, 8, 15.9].map((danced) => measureOf(runs, danced, 4)), ["1 of 3", "1 of 3", "2 of 3", "3 of 3"]);
  assert.deepEqual([4, 5, 10.5, 99].map((danced) => shareOf(runs, danced)), [0, 0, 0.5, 1]);
});

test("what comes next is found, and said", () => {
  const later: Launch = { pad: "formation star", who: "*", state: "waits", due: 16 };
  const sooner: Launch = { pad: "own side step", who: "tide", state: "waits", due: 12 };
  assert.equal(nextOf(told(later, sooner)), sooner);
  assert.equal(nextOf(told({ ...later, due: null }, { ...sooner, state: "runs" })), null);
  assert.equal(launchInWords(sooner), "side step, tide");
  assert.equal(launchInWords(later), "star, everybody");
});

test("what cannot follow is said with its reason", () => {
  assert.deepEqual([WALK, KEPT].map((pad) => measuresAway(told(), pad, "ember")), [2, 2]);
  assert.equal(measuresAway(told(), WALK, "tide"), 0);
  assert.match(awayInWords(2), /2 measures later/);
  assert.match(awayInWords(-1), /no way/);
});

test("a kept pad gets a free name", () => {
  assert.equal(freePadName(WALK, []), "walk");
  assert.equal(freePadName(WALK, ["Walk", "walk 2"]), "walk 3");
});

test("what could come next is launched for its dancers and in the measures that they need", () => {
  const next: WhatNext = { after: "cross", who: "1-8", pads: [{ pad: "formation arrow", name: "arrow", measures: 3 }] };
  assert.equal(nextInWords(next), "after cross, next for 1-8:");
  assert.equal(nextInWords({ ...next, who: "*" }), "after cross, next:");
  assert.deepEqual(nextCall(next, 0, "measure"), ["/dance/launch", "formation arrow", "1-8", "measure", 3]);
  assert.equal(nextCall(next, 1, "measure"), null);
});
