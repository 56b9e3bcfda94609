import assert from "node:assert/strict";
import { test } from "node:test";
import { sceneBox, sceneStart, sheetsFile, svgPoints } from "../src/model/sheets";
import { readDocument } from "../src/net/frames";
import type { Structure } from "../src/model/score";

const STRUCTURE: Structure = {
  revision: 1,
  groups: [{ name: "ember", dancers: 3, colour: [1, 0, 0] }],
  library: [],
  score: {
    section: [{ name: "verse", measures: 8, repeat: 2 }, { name: "chorus", measures: 8 }],
    segment: [{ section: "verse", measure: 1, measures: 4, formation: "line" }, { section: "chorus", measure: 3, measures: 4, formation: "star" }],
    element: [{ section: "chorus", measure: 3, measures: 2, kind: "spread" }],
  },
};
const scene = (section: string, measure: number, measures: number): { words: string; section: string; measure: number; measures: number } => ({ words: "", section, measure, measures });

test("a scene leads to what begins in it, else to what goes on", () => {
  assert.equal(sceneStart(STRUCTURE, scene("Chorus", 3, 2)), 10);
  assert.equal(sceneStart(STRUCTURE, scene("gone", 3, 2)), -1);
  assert.equal(sceneStart({ ...STRUCTURE, score: {} }, scene("", 3, 2)), 2);
  assert.equal(sceneBox(STRUCTURE, scene("chorus", 3, 2))?.label, "star");
  assert.equal(sceneBox(STRUCTURE, scene("chorus", 5, 2))?.label, "star");
  assert.equal(sceneBox(STRUCTURE, scene("verse", 5, 4)), null);
});

test("points, file names and documents", async () => {
  assert.equal(svgPoints([1, 2, 3.5, 4]), "1,2 3.5,4");
  assert.equal(sheetsFile("Zwei Reihen, ça va"), "zwei-reihen-a-va-sheets.pdf");
  assert.equal(sheetsFile("…"), "show-sheets.pdf");
  const frame = new DataView(new Uint8Array([5, 0, 0, 0, 3, 0, 0, 0, 37, 80, 68, 0]).buffer);
  assert.equal(await readDocument(frame).text(), "%PD");
});
