import assert from "node:assert/strict";
import { test } from "node:test";
import { readWaveform } from "../src/net/frames";
import { peaksOf } from "../src/model/wave";

test("the waveform stands at the measures to which it is danced", () => {
  const data = new Uint8Array(8 + 800);
  new DataView(data.buffer).setUint8(0, 3);
  new DataView(data.buffer).setUint16(2, 100, true);
  new DataView(data.buffer).setUint32(4, 800, true);
  data.fill(255, 8 + 200, 8 + 400); // the second measure of 2 s is loud
  const wave = readWaveform(new DataView(data.buffer));
  assert.deepEqual([wave.rate, wave.peaks.length], [100, 800]);
  const score = { music: { bpm: 120, one_at_s: 0 }, clock: { beats_per_measure: 4 } };
  const into = new Float32Array(40);
  assert.equal(peaksOf(wave, score, 0, 40, 10, into), 40);
  assert.deepEqual([into[5], into[12], into[18], into[22]], [0, 1, 1, 0]);
  // a section danced twice: the next one comes later in the music; where somebody has to lead, nothing is known
  const twice = { ...score, section: [{ name: "a", measures: 1, repeat: 2 }, { name: "b", measures: 1, wait: true }, { name: "c", measures: 1 }] };
  peaksOf(wave, twice, 0, 30, 10, into);
  assert.deepEqual([into[5], into[15], into[25]], [0, 0, 0]);
  // lines of the music decide
  const lines = { music: { line: [{ time_s: 2 }, { time_s: 4 }, { time_s: 6 }] } };
  peaksOf(wave, lines, 0, 20, 10, into);
  assert.deepEqual([into[5], into[15]], [1, 0]);
});
