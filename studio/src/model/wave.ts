// The waveform of the music over the measures of the written score.
import { musicTime } from "./plan";
import { dancedFirst } from "./arrange";
import type { SectionSpan } from "./plan";
import type { Score } from "./score";
import type { Waveform } from "../net/frames";

/** The largest peak in each pixel, from 0 to 1; `left`: the first pixel's place, `scale` [px a measure]. */
export function peaksOf(wave: Waveform, score: Score, spans: SectionSpan[], left: number, width: number, scale: number, into: Float32Array): number {
  const count = Math.min(width, into.length);
  // the music's time is asked for at measure lines only; between them it goes evenly
  let measure = Number.NaN;
  let [from, to] = [0, 0];
  const timeAt = (place: number): number => {
    const whole = Math.floor(place);
    if (whole !== measure) {
      measure = whole;
      const danced = dancedFirst(spans, whole) - 1;
      from = musicTime(score, danced);
      to = musicTime(score, danced + 1);
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
