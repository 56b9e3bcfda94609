import assert from "node:assert/strict";
import { test } from "node:test";
import { cleanName, firstOf, labelled, labelOf, LABEL_KEYS, moved, progressOf, renamed, slotAt, slotsOf, suggestionOf, type Pattern, type Take } from "../src/model/labels";

const TAKE: Take = { name: "a", seconds: 10, beats: Array.from({ length: 21 }, (_, index) => 0.2 + 0.48 * index), style: null };

test("slots are so many beats long, follow each other, and end with the take", () => {
  for (const first of [0, 3, 7]) {
    const slots = slotsOf(TAKE, first, 8);
    assert.ok(slots.length >= 2);
    assert.equal(slots[0]?.from, TAKE.beats[first]);
    slots.slice(1).forEach((slot, index) => assert.equal(slot.from, slots[index]?.to));
    assert.ok((slots.at(-1)?.to ?? 99) <= TAKE.seconds);
    slots.forEach((slot, index) => assert.equal(slotAt(slots, 0.5 * (slot.from + slot.to)), index));
  }
  assert.equal(slotAt(slotsOf(TAKE, 0, 8), 0.1), -1);
});

test("a slot has one label, the latest; other takes keep theirs", () => {
  const [one, two] = slotsOf(TAKE, 0, 8);
  assert.ok(one && two);
  let patterns: Pattern[] = [{ take: "b", from_s: 0, to_s: 9, label: "other" }];
  patterns = labelled(patterns, "a", one, "basic");
  patterns = labelled(patterns, "a", two, "turn");
  patterns = labelled(patterns, "a", one, "turn");
  assert.deepEqual([labelOf(patterns, "a", one), labelOf(patterns, "a", two), patterns.length], ["turn", "turn", 3]);
  patterns = labelled(patterns, "a", one, null);
  assert.deepEqual([labelOf(patterns, "a", one), patterns.length], [null, 2]);
});

test("patterns that begin on another beat keep their labels in order, and the beat is found again", () => {
  const before = slotsOf(TAKE, 0, 8);
  const after = slotsOf(TAKE, 2, 8);
  let patterns: Pattern[] = [];
  before.forEach((slot, index) => { patterns = labelled(patterns, "a", slot, `l${index}`); });
  const found = moved(patterns, TAKE, before, after);
  after.forEach((slot, index) => assert.equal(labelOf(found, "a", slot), `l${index}`));
  assert.equal(firstOf(TAKE, found, 8), 2);
  assert.equal(firstOf(TAKE, [], 8), 0);
});

test("names that a file refuses are none; a renamed label is so everywhere", () => {
  assert.deepEqual(["basic", " Füße 2 ", "a/b's + c-d."].map(cleanName), ["basic", "Füße 2", "a/b's + c-d."]);
  assert.deepEqual(["", "-x", "a\"b", "x".repeat(41), "a\nb"].map(cleanName), ["", "", "", "", ""]);
  const made = renamed(["x", "y"], [{ take: "a", from_s: 0, to_s: 1, label: "x" }], "x", "y");
  assert.deepEqual(made, { labels: ["y"], patterns: [{ take: "a", from_s: 0, to_s: 1, label: "y" }] });
});

test("a suggestion is what most of a slot has, if that is more than half", () => {
  const slot = { from: 2, to: 6 };
  const spans = [{ from: 0, to: 3, label: "x" }, { from: 3, to: 4.2, label: "y" }, { from: 4.2, to: 5.5, label: "y" }];
  assert.equal(suggestionOf(spans, slot), "y");
  assert.equal(suggestionOf(spans.slice(0, 2), slot), null);
  assert.equal(suggestionOf([], slot), null);
});

test("progress counts slots; no key is used twice", () => {
  const [slot] = slotsOf(TAKE, 0, 8);
  assert.ok(slot);
  const facts = { pairs: "", file: "", pattern_beats: 8, rate: 30, takes: [TAKE], revision: 0, labels: [], pattern: [] };
  assert.deepEqual(progressOf(facts, labelled([], "a", slot, "x"), { a: 0 }), { done: 1, of: slotsOf(TAKE, 0, 8).length });
  assert.equal(new Set(LABEL_KEYS).size, LABEL_KEYS.length);
});
