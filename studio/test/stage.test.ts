import assert from "node:assert/strict";
import { test } from "node:test";
import { dancedMeasure, placeInScore, writtenStart } from "../src/model/danced";
import { awayFrom, isClosed, isWithin, lengthOf, MOST_POINTS, nearestMoment, nearestTowards, numbersInWords, pairsToMeasure, simplified, type Place } from "../src/model/geometry";
import { bodiesAt, endsOfWays, positionsAt, waysOf } from "../src/model/playback";
import { meetingWords, tooFarWords } from "../src/model/fault_words";
import { drawnEdits, drawnFormation, elementEntry, freeName, liveCall, placedEdits, pointsInWords, type Drawn } from "../src/model/stage_edits";
import { readPositions, type Positions } from "../src/net/frames";

const circle = (points: number, radius = 2): Place[] => Array.from({ length: points }, (_, at) => [radius * Math.cos((2 * Math.PI * at) / points), radius * Math.sin((2 * Math.PI * at) / points)]);

test("a drawn line keeps its form with fewer points, never more than the engine follows", () => {
  const line = circle(6000);
  const few = simplified(line, 0.02);
  assert.ok(few.length < 60 && few.length > 10);
  for (const place of line) assert.ok(Math.min(...few.map((one, at) => awayFrom(place, one, few[at + 1] ?? one))) <= 0.021);
  const rough: Place[] = Array.from({ length: 2000 }, (_, at) => [at / 500, (at * 7919) % 13]);
  assert.ok(simplified(rough, 0.001).length <= MOST_POINTS);
  assert.deepEqual(simplified([[0, 0], [1, 0]]), [[0, 0], [1, 0]]);
  assert.deepEqual(simplified([[0, 0], [0.5, 0.001], [1, 0]]), [[0, 0], [1, 0]]);
});

test("closed lines, and who is within", () => {
  assert.ok(isClosed([...circle(60)]));
  assert.ok(!isClosed([[0, 0], [1, 0], [2, 0], [3, 0]]));
  assert.ok(isWithin([0.5, 0.5], circle(40)));
  assert.ok(!isWithin([2.1, 0], circle(40)));
  assert.ok(Math.abs(lengthOf(circle(400)) - 4 * Math.PI) < 0.1);
});

test("arrows go to the nearest dancer in their direction, and never back", () => {
  const places: (Place | null)[] = [[0, 0], [1, 0.1], [3, 0], [0, 2], null, [-1, 0]];
  assert.equal(nearestTowards(places, [0, 0], 1, 0), 1);
  assert.equal(nearestTowards(places, [1, 0.1], 1, 0), 2);
  assert.equal(nearestTowards(places, [0, 0], 0, 1), 3);
  assert.equal(nearestTowards(places, [0, 0], -1, 0), 5);
  assert.equal(nearestTowards(places, [0, 0], 0, -1), -1);
});

test("distances of a few are all told, of many only the nearest", () => {
  assert.equal(pairsToMeasure([[0, 0], [1, 0], [2, 0]]).length, 3);
  assert.deepEqual(pairsToMeasure([[0, 0], [1, 0], [5, 0], [6, 0], [20, 0]]), [[0, 1], [2, 3], [4, 3]]);
});

test("two ways meet where they are nearest at the same time", () => {
  assert.equal(nearestMoment([[0, 0], [1, 0], [2, 0]], [[2, 0], [1, 0.1], [0, 0]]), 1);
  assert.equal(nearestMoment([], [[1, 1]]), -1);
});

test("numbers of dancers in words", () => {
  assert.equal(numbersInWords([7, 1, 2, 3, 9, 10]), "1-3 + 7 + 9-10");
  assert.equal(numbersInWords([]), "");
});

const SECTIONS = { section: [{ name: "a", measures: 4, repeat: 2 }, { name: "b", measures: 8, then: "d" }, { name: "c", measures: 2 }, { name: "d", measures: 3, wait: true }, { name: "e", measures: 1 }] };

test("a written measure is danced when its section comes first", () => {
  assert.equal(dancedMeasure({}, 56), 57);
  assert.equal(dancedMeasure(SECTIONS, 3), 4);
  assert.equal(dancedMeasure(SECTIONS, 4), 9);
  assert.equal(dancedMeasure(SECTIONS, 14), 17); // d, after b
  assert.equal(dancedMeasure(SECTIONS, 12), null); // nobody comes to c
  assert.equal(dancedMeasure(SECTIONS, 17), null); // d waits
  assert.deepEqual(placeInScore(SECTIONS, 5), { measure: 2, section: "b" });
  assert.deepEqual(placeInScore({}, 5), { measure: 6 });
  assert.equal(writtenStart(SECTIONS, { section: "B", measure: 3, beat: 3 }, 4), 6.5);
});

const at = (...rows: number[]): Positions => ({ tick: 0, count: rows.length / 3, rows: Float32Array.from(rows), present: new Uint8Array(rows.length / 3).fill(1) });

test("between two samples everybody is between, and turns the shorter way", () => {
  const moments = [{ tick: 0, measure: 5, time_s: 10 }, { tick: 4, measure: 5.5, time_s: 11 }, { tick: 8, measure: 6, time_s: 12 }];
  const samples = [at(0, 0, 3), at(1, 2, -3), at(1, 2, 0)];
  const middle = positionsAt(moments, samples, 5.25, "measure");
  assert.deepEqual([...(middle?.rows ?? [])].slice(0, 2), [0.5, 1]);
  assert.ok(Math.abs(Math.abs(middle?.rows[2] ?? 0) - Math.PI) < 1e-5);
  assert.deepEqual([...(positionsAt(moments, samples, 99, "time_s")?.rows ?? [])], [1, 2, 0]);
  assert.deepEqual([...(positionsAt(moments, samples, 0, "time_s")?.rows ?? [])], [0, 0, 3]);
  assert.equal(positionsAt(moments, [], 5, "measure"), null);
  const bodies = [0, 2, 4].map((x) => ({ tick: 0, count: 1, chosen: false, rows: Float32Array.from([x, 1, 0]) }));
  assert.deepEqual([...(bodiesAt(moments, bodies, 10.5) ?? [])], [1, 1, 0]);
  assert.equal(bodiesAt(moments, [], 10.5), null);
  assert.deepEqual(waysOf(samples), { dancers: [1], ways: [[[0, 0], [1, 2], [1, 2]]] });
  assert.deepEqual([...endsOfWays([[[0, 0], [4, 5]]], [1], at(0, 0, 1)).rows], [4, 5, 1]);
});

const DRAWN: Drawn = {
  becomes: "formation", points: circle(30), closed: true, start: 5, measures: 4, group: "*", name: "drawn 1", inside: false, pattern: "", many: "dancers",
  amount: 12, mirror: "", keep: "", singleFile: false, strength: 1, material: null,
};

test("a drawn line becomes a formation, a way or an element", () => {
  assert.equal(freeName({ formation: [{ name: "Drawn 1" }] }, "drawn"), "drawn 2");
  const inside = drawnFormation({ ...DRAWN, inside: true, pattern: "grid", many: "density", amount: 0.5, mirror: "left-right", keep: "right" });
  assert.deepEqual({ ...inside, points: 0 }, { name: "drawn 1", shape: "polyline", points: 0, closed: true, dancers: "inside", pattern: "grid", density: 0.5, mirror: "left-right", mirror_keep: "right" });
  const [formation, segment] = drawnEdits(SECTIONS, DRAWN);
  assert.deepEqual(formation?.at, ["formation"]);
  assert.deepEqual(segment?.value, { measure: 2, section: "b", measures: 4, formation: "drawn 1" });
  const [way] = drawnEdits({}, { ...DRAWN, becomes: "way", points: [[0, 0], [2, 1]], closed: false, group: "ember", singleFile: true });
  assert.deepEqual(way?.value, { measure: 6, measures: 4, group: "ember", path: [[0, 0], [2, 1]], single_file: true });
  const [flow] = drawnEdits({}, { ...DRAWN, becomes: "flow", points: [[0, 0], [2, 1]], closed: false, strength: 2 });
  assert.deepEqual(flow?.value, { kind: "flow", measure: 6, measures: 4, points: [[0, 0], [2, 1]], strength: 2, flow: "drawn" });
});

test("live calls fit into a message", () => {
  assert.ok(pointsInWords(circle(500, 9)).length <= 250);
  assert.deepEqual(liveCall("attract", [[1, 2]], 0.8, 4, "*"), ["/dance/attract", 1, 2, 0.8, 4, "*"]);
  assert.deepEqual(liveCall("spread", [[1, 2]], 0.8, 4, "ember"), ["/dance/spread", 4, "ember"]);
  assert.deepEqual(liveCall("cross", [[0, -1], [0, 1]], 1, 2, "*"), ["/dance/cross", 0, -1, 0, 1, 1, 2, "*"]);
  assert.equal(liveCall("flow", circle(9), 1, 2, "*")[0], "/dance/flow/drawn");
  assert.deepEqual(elementEntry({}, "cross", [[0, -1.234], [0, 1]], 2, 4, 1, "1-3"), { kind: "cross", measure: 3, measures: 4, at: [0, -1.23], to: [0, 1], group: "1-3" });
});

test("places put by hand become a formation, or change one", () => {
  const [made, used] = placedEdits({}, "placed 1", 0, [[0.004, 1], [2, 0]], [0, 30], { start: 3, measures: 2, group: "1-2" });
  assert.deepEqual(made?.value, { name: "placed 1", shape: "places", points: [[0, 1], [2, 0]], headings_deg: [0, 30] });
  assert.deepEqual(used?.value, { measure: 4, measures: 2, group: "1-2", formation: "placed 1", match: "number" });
  const [changed] = placedEdits({ formation: [{ name: "f", shape: "circle", size: [2, 2], headings_deg: [1] }] }, "f", 1, [[0, 0]], [0], null);
  assert.deepEqual(changed, { do: "change", at: ["formation", 1], value: { size: null, headings_deg: null, shape: "places", points: [[0, 0]] } });
});

test("faults are told a line for each measure", () => {
  const far = (dancer: number, measure = 13): { measure: number; dancer: number; distance: number; reach: number } => ({ measure, dancer, distance: 1 + dancer / 10, reach: 1.61 });
  assert.deepEqual(tooFarWords([far(10), far(11), far(14), far(2, 12)]), [
    "Measure 12: too far for 2: up to 1.2 m; steps reach 1.6 m", "Measure 13: too far for 10-11, 14: up to 2.4 m; steps reach 1.6 m",
  ]);
  const pairs = Array.from({ length: 8 }, (_, at) => ({ measure: 3, dancers: [1, at + 2] as [number, number], distance: 0.3 }));
  assert.equal(meetingWords(pairs)[0], "Measure 3: 1 and 2, 1 and 3, 1 and 4, 1 and 5, 1 and 6, 1 and 7 and 2 more pairs would meet (0.30 m)");
});

test("the state of a dancer is the number of their group", () => {
  const data = new DataView(new ArrayBuffer(8 + 16));
  data.setUint8(0, 1);
  data.setUint16(2, 2, true);
  data.setInt16(8, -1500, true);
  data.setInt16(14, 3, true);
  const found = readPositions(data);
  assert.deepEqual([found.count, found.rows[0], [...found.present]], [2, -1.5, [3, 0]]);
});
