import assert from "node:assert/strict";
import { test } from "node:test";
import { bendEdits, bentTable, dancersIn, drawnGround, groundAt, materialOf, materials, namedGround, triedEdits, type Material } from "../src/model/material";
import type { Place } from "../src/model/geometry";
import type { Score } from "../src/model/score";

const SQUARE: Place[] = [[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]];
const LARGE: Place[] = SQUARE.map(([x, z]) => [4 * x, 4 * z]);
const SCORE: Score = {
  formation: [{ name: "Star", shape: "star" }, { name: "corner", like: "star", into: [[0, 0], [3, 0], [0, 3]], proportions: "stretch" }, { name: "yard", shape: "rectangle" }],
  evolution: [{ name: "flock", ways: [[[0, 0], [1, 1]]] }],
  segment: [{ measure: 1, formation: "star" }, { measure: 5, formation: "corner", group: "tide" }, { measure: 9, evolution: "flock" }, { measure: 13, path: [[0, 0], [1, 1]] }],
};
const PUT = { start: 4, measures: 2, group: "tide" };

test("what a segment dances can be bent, a path cannot", () => {
  assert.deepEqual([1, 2, 3, 4, 5].map((one) => materialOf(SCORE, one)?.name ?? null), ["star", "corner", "flock", null, null]);
  assert.deepEqual(materials(SCORE, 3).slice(0, 3).map((one) => [one.list, one.name, one.segment]), [["evolution", "flock", 3], ["evolution", "flock", 0], ["formation", "Star", 0]]);
});

test("a drawn line is a line, a closed one a region without its last point", () => {
  assert.deepEqual(drawnGround([[0, 0], [1, 0.001], [2, 0]], false), { kind: "along", to: [[0, 0], [2, 0]], lines: [[[0, 0], [2, 0]]] });
  const region = drawnGround(SQUARE, true);
  assert.deepEqual(region.to, SQUARE.slice(0, 4));
  assert.deepEqual(region.lines, [SQUARE]);
});

test("the smallest region around a place, outside of holes, or a line that is near", () => {
  const [small, large] = [namedGround("small", [SQUARE]), namedGround("ring", [LARGE, SQUARE])];
  const line = namedGround("line", [[[0, 3], [3, 3]]]);
  assert.ok(small && large && line && line.kind === "along");
  assert.equal(groundAt([0, 0], [large, small]), small);
  assert.equal(groundAt([0, 0], [large]), null);
  assert.equal(groundAt([2, 2], [large, small, line]), large);
  assert.equal(groundAt([2, 2.8], [large, small, line]), line);
  assert.equal(groundAt([9, 9], [large, small, line]), null);
  assert.equal(namedGround("two lines", [[[0, 0], [1, 0]], [[0, 1], [1, 1]]]), null);
  assert.equal(namedGround("nothing", []), null);
});

test("the edits of a drop: a segment's own bent formation changes, others become new ones", () => {
  const region = drawnGround(LARGE, true);
  const yard = namedGround("yard", [SQUARE]) as NonNullable<ReturnType<typeof namedGround>>;
  const of = (segment: number): Material => materialOf(SCORE, segment) as Material;
  assert.deepEqual(bendEdits(SCORE, of(1), region, PUT), [
    { do: "insert", at: ["formation"], value: { like: "star", name: "star in a region", into: region.to } },
    { do: "set", at: ["segment", 1, "formation"], value: "star in a region" },
  ]);
  assert.deepEqual(bendEdits(SCORE, of(2), yard, PUT), [{ do: "change", at: ["formation", 2], value: { into: "yard", along: null } }]);
  const used: Score = { ...SCORE, segment: [...(SCORE["segment"] as []), { measure: 20, formation: "Corner" }] };
  assert.deepEqual(bentTable(used, of(2), yard), { name: "corner in a region", like: "star", proportions: "stretch", into: "yard" });
  assert.equal(bendEdits(used, of(2), yard, PUT).length, 2);
  assert.deepEqual(bendEdits(SCORE, { list: "evolution", name: "flock", segment: 0 }, drawnGround([[0, 0], [3, 0]], false), PUT), [
    { do: "insert", at: ["evolution"], value: { like: "flock", name: "flock along a line", along: [[0, 0], [3, 0]] } },
    { do: "insert", at: ["segment"], value: { measure: 5, measures: 2, group: "tide", evolution: "flock along a line" } },
  ]);
  assert.deepEqual(triedEdits(SCORE, of(1), [[1, 2]], PUT)[1], { do: "set", at: ["segment", 1, "formation"], value: "dragged" });
  assert.equal(bentTable(SCORE, { list: "formation", name: "star:6, 'x'", segment: 0 }, region)["name"], "star 6 x in a region");
});

test("dancers of words", () => {
  const groups = [{ name: "Ember", dancers: 3, colour: [0, 0, 0] as [number, number, number] }, { name: "tide", dancers: 2, colour: [0, 0, 0] as [number, number, number] }];
  assert.deepEqual(dancersIn(groups, "*"), [1, 2, 3, 4, 5]);
  assert.deepEqual(dancersIn(groups, "TIDE + 1-2"), [1, 2, 4, 5]);
  assert.equal(dancersIn(groups, "front half"), null);
  assert.equal(dancersIn(groups, "4-9"), null);
});
