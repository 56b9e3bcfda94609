// What would go wrong in some measures, in words: a line for each measure and kind.
import { numbersInWords } from "./geometry";
import type { Meeting, TooFar } from "./stage_state";

const MOST_PAIRS = 6;

function byMeasure<T extends { measure: number }>(rows: T[]): [number, T[]][] {
  const found = new Map<number, T[]>();
  for (const row of rows) found.set(row.measure, [...(found.get(row.measure) ?? []), row]);
  return [...found].sort((a, b) => a[0] - b[0]);
}

export function meetingWords(rows: Meeting[]): string[] {
  return byMeasure(rows).map(([measure, all]) => {
    const pairs = all.slice(0, MOST_PAIRS).map((one) => one.dancers.join(" and "));
    const rest = all.length - pairs.length;
    return `Measure ${measure}: ${pairs.join(", ")}${rest ? ` and ${rest} more pairs` : ""} would meet (${Math.min(...all.map((one) => one.distance)).toFixed(2)} m)`;
  });
}

export function tooFarWords(rows: TooFar[]): string[] {
  return byMeasure(rows).map(([measure, all]) => {
    const most = Math.max(...all.map((one) => one.distance)).toFixed(1);
    const reach = Math.min(...all.map((one) => one.reach)).toFixed(1);
    return `Measure ${measure}: too far for ${numbersInWords(all.map((one) => one.dancer)).replaceAll(" + ", ", ")}: up to ${most} m; steps reach ${reach} m`;
  });
}
