// Positions between the samples of the preview.
import type { Moment } from "../net/preview";
import type { Joints, Positions } from "../net/frames";
import type { Place } from "./geometry";

/** Index of the last moment whose value is not above `wanted`; 0 if all are. */
export function indexAt(moments: Moment[], wanted: number, by: "measure" | "time_s"): number {
  let low = 0;
  let high = moments.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if ((moments[middle] as Moment)[by] <= wanted) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** Where everybody stands at a measure (from 1, with a fraction) or a time, between two samples; null without any. */
export function positionsAt(moments: Moment[], samples: Positions[], wanted: number, by: "measure" | "time_s", into?: Positions): Positions | null {
  if (!samples.length || samples.length !== moments.length) return null;
  const index = indexAt(moments, wanted, by);
  const a = samples[index] as Positions;
  const b = samples[index + 1];
  const from = (moments[index] as Moment)[by];
  const to = moments[index + 1]?.[by] ?? from;
  const share = b && to > from ? Math.min(1, Math.max(0, (wanted - from) / (to - from))) : 0;
  const found = into?.count === a.count ? into : { tick: 0, count: a.count, rows: new Float32Array(3 * a.count), present: new Uint8Array(a.count) };
  found.tick = a.tick;
  found.present.set(a.present);
  for (let at = 0; at < a.rows.length; at++) {
    const here = a.rows[at] as number;
    let by_ = b ? (b.rows[at] as number) - here : 0;
    if (at % 3 === 2) by_ = Math.atan2(Math.sin(by_), Math.cos(by_)); // a heading turns the shorter way
    found.rows[at] = here + share * by_;
  }
  return found;
}

/** Joints at a time between two samples, straight from one to the other; null without any. */
export function bodiesAt(moments: Moment[], bodies: Joints[], time: number, into?: Float32Array): Float32Array | null {
  if (!bodies.length || bodies.length !== moments.length) return null;
  const index = indexAt(moments, time, "time_s");
  const a = (bodies[index] as Joints).rows;
  const b = bodies[index + 1]?.rows ?? a;
  const from = (moments[index] as Moment).time_s;
  const to = moments[index + 1]?.time_s ?? from;
  const share = to > from ? Math.min(1, Math.max(0, (time - from) / (to - from))) : 0;
  const found = into?.length === a.length ? into : new Float32Array(a.length);
  for (let at = 0; at < a.length; at++) found[at] = (a[at] as number) + share * ((b[at] as number) - (a[at] as number));
  return found;
}

/** The way of each dancer through samples. */
export function waysOf(samples: Positions[]): { dancers: number[]; ways: Place[][] } {
  const count = samples[0]?.count ?? 0;
  const dancers = Array.from({ length: count }, (_, row) => row + 1).filter((one) => samples.every((each) => each.present[one - 1]));
  return { dancers, ways: dancers.map((one) => samples.map((each) => [each.rows[3 * (one - 1)] ?? 0, each.rows[3 * (one - 1) + 1] ?? 0] as Place)) };
}

/** Positions at the ends of planned ways; headings, and those without a way, as given. */
export function endsOfWays(ways: Place[][], dancers: number[], like: Positions): Positions {
  const found: Positions = { tick: like.tick, count: like.count, rows: new Float32Array(like.rows), present: new Uint8Array(like.present) };
  dancers.forEach((dancer, index) => {
    const last = ways[index]?.at(-1);
    if (!last || dancer > like.count) return;
    found.rows[3 * (dancer - 1)] = last[0];
    found.rows[3 * (dancer - 1) + 1] = last[1];
  });
  return found;
}
