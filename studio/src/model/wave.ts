// The waveform of the music over the measures of the written score.
import { musicTime } from "./plan";
import { dancedMeasure } from "./danced";
import type { Score } from "./score";
import type { Waveform } from "../net/frames";

const known = new WeakMap<Score, Map<number, [number, number]>>();

/** When a measure of the written score (from 0) begins and ends in the music [s], where it is danced first. */
function timesOf(score: Score, whole: number): [number, number] {
  let times = known.get(score);
  if (!times) known.set(score, (times = new Map()));
  let found = times.get(whole);
  if (!found) {
    const danced = dancedMeasure(score, whole);
    found = danced === null ? [-1, -1] : [musicTime(score, danced - 1), musicTime(score, danced)];
    times.set(whole, found);
  }
  return found;
}

/** The largest peak in each pixel, from 0 to 1; `left`: the first pixel's place, `scale` [px a measure]. */
export function peaksOf(wave: Waveform, score: Score, left: number, width: number, scale: number, into: Float32Array): number {
  const count = Math.min(width, into.length);
  // the music's time is asked for at measure lines only; between them it goes evenly
  let measure = Number.NaN;
  let [from, to] = [0, 0];
  const timeAt = (place: number): number => {
    const whole = Math.floor(place);
    if (whole !== measure) {
      measure = whole;
      [from, to] = timesOf(score, whole);
    }
    return from + (place - whole) * (to - from);
  };
  let index = Math.floor(timeAt(left / scale) * wave.rate);
  for (let pixel = 0; pixel < count; pixel++) {
    const end = Math.floor(timeAt((left + pixel + 1) / scale) * wave.rate);
    if (end < index) index = end; // the next section is danced to another place of the music
    let peak = 0;
    const last = Math.max(end, index + 1);
    const step = Math.max(1, Math.floor((last - index) / 64));
    for (let at = Math.max(index, 0); at < last && at < wave.peaks.length; at += step) peak = Math.max(peak, wave.peaks[at] as number);
    into[pixel] = peak / 255;
    index = end;
  }
  return count;
}
