// Where a measure of the written score is danced first: sections are repeated, and lead to one another.
import { sectionSpans, type SectionSpan } from "./plan";
import { text, type Entry, type Score } from "./score";

const LATEST = 10_000;

/** The danced measure (from 1) in which a measure of the written score (from 0) comes first; null if somebody has to lead there. */
export function dancedMeasure(score: Score, written: number): number | null {
  const spans = sectionSpans(score);
  const whole = Math.floor(written);
  if (!spans.length) return whole + 1;
  let danced = 0;
  const seen = new Set<number>();
  for (let at = 0; danced < LATEST && !seen.has(at); ) {
    const span = spans[at] as SectionSpan;
    if (whole >= span.first && whole < span.first + span.measures) return danced + whole - span.first + 1;
    if (span.wait || span.repeat === 0) return null;
    seen.add(at);
    danced += span.measures * span.repeat;
    if (span.then.toLowerCase() === "end") return null;
    const next = span.then ? spans.findIndex((one) => one.name.toLowerCase() === span.then.toLowerCase()) : (at + 1) % spans.length;
    if (next < 0) return null;
    at = next;
  }
  return null;
}

/** Measures as the preview counts them, from 1; `led`: they come only if somebody leads there, and are counted as they are written. */
export interface Reached {
  from: number;
  to: number;
  led: boolean;
}

/** Where some measures of the written score (from 0) are danced, or would be if somebody led there. */
export function reached(score: Score, written: number, measures = 1): Reached {
  const danced = dancedMeasure(score, written);
  const from = danced ?? Math.floor(written) + 1;
  return { from, to: from + Math.max(Math.ceil(measures), 1) - 1, led: danced === null };
}

/** For a question to the preview. */
export function asLed(led: boolean): { led?: true } {
  return led ? { led: true } : {};
}

/** The written measure (from 0, with a fraction) at which an entry begins. */
export function writtenStart(score: Score, entry: Entry, beats: number): number {
  const name = text(entry, "section").toLowerCase();
  const span = name ? sectionSpans(score).find((one) => one.name.toLowerCase() === name) : undefined;
  return (span?.first ?? 0) + Number(entry["measure"] ?? 1) - 1 + (Number(entry["beat"] ?? 1) - 1) / beats;
}

/** As `measure` and `section` of an entry: where a written measure (from 0) lies. */
export function placeInScore(score: Score, written: number): { measure: number; section?: string } {
  const span = sectionSpans(score).find((one) => written >= one.first && written < one.first + one.measures);
  return span ? { measure: written - span.first + 1, section: span.name } : { measure: written + 1 };
}
