import assert from "node:assert/strict";
import { test } from "node:test";
import { isLed, measuresText, neighbours, pictures, placeText, ranges, title, type Taken } from "../src/model/storyboard";
import { reached } from "../src/model/danced";
import type { Structure } from "../src/model/score";

const STRUCTURE: Structure = {
  revision: 1,
  groups: [{ name: "ember", dancers: 3, colour: [1, 0, 0] }],
  library: [],
  score: {
    stage: { width: 8, depth: 6 },
    section: [{ name: "verse", measures: 8, repeat: 2 }, { name: "chorus", measures: 8 }],
    segment: [
      { section: "verse", measure: 1, measures: 4, formation: "line" },
      { section: "chorus", measure: 3, measures: 2, formation: "star" },
      { section: "chorus", measure: 1, measures: 4, formation: "grid", group: "ember" },
    ],
  },
};

test("a picture for the beginning and each arrival, where it is danced first", () => {
  const all = pictures(STRUCTURE);
  assert.deepEqual(all.map((one) => [one.first, one.last, one.danced, one.section]), [[0, 0, 1, "verse"], [0, 4, 5, "verse"], [8, 12, 21, "chorus"]]);
  assert.deepEqual(all.map(measuresText), ["beginning", "measures 1 to 4", "measures 9 to 12"]);
  assert.deepEqual(all.map(title), ["All begin here", "line", "star, grid (ember)"]);
  assert.deepEqual(ranges(all), [[1, 5], [21, 21]]);
  assert.deepEqual(ranges(all.concat([{ ...(all[0] as never as (typeof all)[0]), danced: 90 }, { ...(all[0] as (typeof all)[0]), danced: 100 }])), [[1, 5], [21, 21], [90, 100]]);
});

test("places and neighbours as the public sees them", () => {
  assert.equal(placeText(0, 0, STRUCTURE), "on the centre line, halfway back");
  assert.equal(placeText(-1.24, 2.9, STRUCTURE), "1.2 m left, 2.9 m in front, at the edge");
  const taken: Taken = { rows: new Float32Array([-2, 0, 0, 0, 0, 0, 1, 0.2, 0, 0.1, 2.9, 0]), present: new Uint8Array([1, 1, 1, 1]), steps: [] };
  assert.deepEqual(neighbours(taken, 2), { left: 1, right: 3 });
  taken.present[0] = 0;
  assert.deepEqual(neighbours(taken, 2), { left: null, right: 3 });
});

test("behind a section that waits the pictures are those of somebody who leads", () => {
  const score = { ...STRUCTURE.score, section: [{ name: "verse", measures: 8, wait: true }, { name: "chorus", measures: 8 }] };
  const waiting: Structure = { ...STRUCTURE, score };
  assert.equal(isLed(STRUCTURE), false);
  assert.equal(isLed(waiting), true);
  assert.deepEqual(pictures(waiting).map((one) => [one.first, one.last, one.danced]), [[0, 0, 1], [0, 4, 5], [8, 12, 13]]);
  assert.deepEqual(reached(STRUCTURE.score, 9, 4), { from: 18, to: 21, led: false });
  assert.deepEqual(reached(score, 9, 4), { from: 10, to: 13, led: true });
  assert.deepEqual(reached(score, 3, 0), { from: 4, to: 4, led: false });
});
