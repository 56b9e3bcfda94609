// A dancer as lines: 22 joints seen from the front, from the side or from above.
import type { Joints } from "../net/frames";
import { JOINT_COUNT } from "../net/frames";
import type { Clock } from "./document";

export type Look = "front" | "side" | "above";

/** Chains of joints, drawn as one line each; farther ones first. `side`: the dancer's own. */
export const LIMBS: { joints: number[]; side: "" | "left" | "right"; width: number }[] = [
  { joints: [18, 19, 20, 21], side: "right", width: 0.11 },
  { joints: [14, 15, 16, 17], side: "left", width: 0.11 },
  { joints: [18, 0, 14], side: "", width: 0.16 },
  { joints: [0, 1, 2, 3, 4], side: "", width: 0.2 },
  { joints: [3, 10, 11, 12, 13], side: "right", width: 0.085 },
  { joints: [3, 6, 7, 8, 9], side: "left", width: 0.085 },
];
export const HEAD = 5;
export const HEAD_M = 0.12;

/** A take of a step, sample by sample. */
export interface Motion {
  beats: number;
  samplesPerBeat: number;
  samples: Joints;
  /** Of each sample: 1 the left foot is on the floor, 2 the right one, 3 both. */
  contact: number[];
}

/** Where a joint is seen [m]: to the right, and down. */
export function seen(look: Look, x: number, y: number, z: number): [number, number] {
  if (look === "front") return [x, -y];
  if (look === "side") return [z, -y];
  return [x, z];
}

/** The joints at a beat of the step (from 0; it begins again), between samples as well: x, y, z of each [m]. */
export function poseAt(motion: Motion, beat: number, into: Float32Array = new Float32Array(3 * JOINT_COUNT)): Float32Array {
  const { samples, beats, samplesPerBeat } = motion;
  const whole = ((beat % beats) + beats) % beats;
  const at = Math.min(whole * samplesPerBeat, samples.count - 1);
  const before = Math.floor(at);
  const after = Math.min(before + 1, samples.count - 1);
  const part = at - before;
  const size = 3 * JOINT_COUNT;
  for (let index = 0; index < size; index++) {
    const a = samples.rows[before * size + index] ?? 0;
    const b = samples.rows[after * size + index] ?? 0;
    into[index] = a + part * (b - a);
  }
  return into;
}

export interface Extent {
  left: number;
  top: number;
  right: number;
  bottom: number;
}

/** What a motion takes up, seen from a side [m]. `still`: with the hips held in the middle. */
export function extentOf(motion: Motion, look: Look, still: boolean): Extent {
  const found = { left: Infinity, top: Infinity, right: -Infinity, bottom: -Infinity };
  const size = 3 * JOINT_COUNT;
  for (let sample = 0; sample < motion.samples.count; sample++) {
    const rows = motion.samples.rows.subarray(sample * size, (sample + 1) * size);
    const [hx, hz] = still ? [rows[0] ?? 0, rows[2] ?? 0] : [0, 0];
    for (let joint = 0; joint < JOINT_COUNT; joint++) {
      const [px, py] = seen(look, (rows[3 * joint] ?? 0) - hx, rows[3 * joint + 1] ?? 0, (rows[3 * joint + 2] ?? 0) - hz);
      found.left = Math.min(found.left, px);
      found.right = Math.max(found.right, px);
      found.top = Math.min(found.top, py);
      found.bottom = Math.max(found.bottom, py);
    }
  }
  const edge = 0.16;
  const bottom = look === "above" ? found.bottom + edge : 0.06;
  return { left: found.left - edge, right: found.right + edge, top: found.top - edge, bottom };
}

/** Beats of the show so far at a time of this page; without music a steady 110 a minute. `heard`: when the clock came. */
export function beatNow(clock: Clock | null, heard: number, now: number, beatsPerMeasure: number): number {
  if (!clock || clock.measure < 1) return (now / 60_000) * 110;
  const since = Math.min(Math.max(now - heard, 0), 1000);
  return (clock.measure - 1) * beatsPerMeasure + (clock.beat - 1) + (since / 60_000) * clock.bpm;
}
