import assert from "node:assert/strict";
import { test } from "node:test";
import { calling, choiceOf, choicesOf, found, wordsOfCall } from "../src/model/controls";
import { dragged, wordsOfDancers } from "../src/model/form";
import type { Surface, Widget } from "../src/net/values";

const widget = (address: string, more: Partial<Widget> = {}): Widget => ({
  address, label: address.split("/").slice(3).join("_") || address.split("/")[2] || "", kind: "button", words: "", values: [], once: false, minimum: [], maximum: [], start: [], ...more,
});
const SURFACE: Surface = {
  name: "show", readings: {},
  pages: [
    { title: "show", widgets: [widget("/dance/spread"), widget("/dance/undo")] },
    { title: "light", widgets: [widget("/dance/light/key_level", { kind: "fader", minimum: [0], maximum: [2], start: [1], words: "How bright" })] },
    { title: "formation", widgets: [widget("/dance/formation", { label: "opening", values: ["opening"] }), widget("/dance/formation", { label: "heart", values: ["heart"] })] },
    { title: "midi", widgets: [widget("/dance/midi/learn")] },
  ],
};

test("a score calls controls by words, none of the machine", () => {
  const choices = choicesOf(SURFACE);
  assert.deepEqual(choices.map((one) => one.words), ["spread", "key level", "opening", "heart"]);
  assert.deepEqual(found(choices, "BRIGHT light").map((one) => one.words), ["key level"]);
  assert.deepEqual(calling(choices[1] as never), { call: "/dance/light/key_level", values: [1] });
});

test("an entry finds its control again, by its values where several have the address", () => {
  const choices = choicesOf(SURFACE);
  assert.equal(choiceOf(choices, { call: "/dance/formation", values: ["heart"] })?.words, "heart");
  assert.equal(wordsOfCall(choices, { call: "/dance/light/key_level", values: [0.5] }), "light: key level");
  assert.equal(wordsOfCall(choices, { call: "/dance/look_at/me" }), "look at me");
});

test("numbers are dragged by steps, within their limits", () => {
  const whole = { key: "measures", words: "measures", control: "integer", help: "", least: 1, most: 64 };
  assert.deepEqual([dragged(whole, 25, 39), dragged(whole, 60, 39), dragged(whole, 3, -9)], [64, 64, 1]);
  assert.equal(dragged({ ...whole, control: "number", least: 0, most: 1 }, 0.5, 7), 0.57);
});

test("dancers by number are told to be dancers", () => {
  assert.deepEqual(["6", "1-2 + 5", "ember & left"].map(wordsOfDancers), ["dancer 6", "dancers 1–2, 5", "ember & left"]);
});
