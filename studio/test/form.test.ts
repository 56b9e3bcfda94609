import assert from "node:assert/strict";
import { test } from "node:test";
import { colourOfHex, common, dancerWords, fieldEdits, fieldsOf, hexOf, namesOf, readNumber, readNumbers, readSteps, toggled, writeSteps, type Field } from "../src/model/form";

test("fields come from the schema, others are shown as they are", () => {
  const fields = fieldsOf("segment", { measure: 1, strange: 3 });
  assert.equal(fields[0]?.key, "measure");
  assert.deepEqual(fields.find((one) => one.key === "match")?.choices?.slice(0, 2), ["squared", "shortest"]);
  assert.equal(fields.at(-1)?.key, "strange");
  assert.deepEqual(fieldsOf("nothing", { a: 1 }).map((one) => [one.key, one.control]), [["a", "json"]]);
});

test("several entries, and edits of a field", () => {
  assert.deepEqual(common([{ a: 1 }, { a: 1 }], "a"), { value: 1, same: true, written: true });
  assert.deepEqual(common([{ a: 1 }, {}], "a"), { value: 1, same: false, written: true });
  assert.deepEqual(fieldEdits("segment", [1, 4], "hold", undefined), [
    { do: "set", at: ["segment", 1, "hold"], value: null }, { do: "set", at: ["segment", 4, "hold"], value: null },
  ]);
  assert.deepEqual(fieldEdits("section", [2], "name", "end"), [{ do: "rename", at: ["section", 2], value: "end" }]);
});

test("what is typed", () => {
  const field: Field = { key: "a", words: "a", control: "integer", help: "", least: 1, most: 9 };
  assert.deepEqual(["3,4", "77", "x", ""].map((said) => readNumber(field, said)), [3, 9, null, null]);
  assert.deepEqual(readNumbers("1, 2.5 -3"), [1, 2.5, -3]);
  assert.equal(readNumbers("1, b"), null);
  for (const hex of ["#12ab80", "#000000", "#050301", "#ffffff"]) assert.equal(hexOf(colourOfHex(hex)), hex);
  assert.deepEqual(["#F80", "#Ff8800", "no colour", null].map(hexOf), ["#ff8800", "#ff8800", "#808080", "#808080"]);
  assert.equal(hexOf([0.5, 0, 0]), "#ba0000"); // half the light looks brighter than half
});

test("dancers, names and steps", () => {
  const score = { group: [{ name: "ember", attributes: ["tall"] }, { name: "tide" }], section: [{ name: "verse" }] };
  assert.deepEqual(dancerWords(score).slice(0, 3), ["ember", "tide", "tall"]);
  assert.deepEqual(namesOf(score, "section"), ["verse", "end"]);
  assert.equal(toggled("*", "ember"), "ember");
  assert.equal(toggled("ember", "Tide"), "ember + Tide");
  assert.equal(toggled("ember + tide", "Ember"), "tide");
  assert.equal(toggled("ember", "ember"), "*");
  assert.deepEqual(writeSteps(readSteps(["walk x2, turn", "jump"])), ["walk x2", "turn", "jump"]);
});
