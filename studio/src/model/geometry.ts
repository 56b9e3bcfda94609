// Geometry of the stage from above. A place is (x, z) [m]: x to the right as the public sees it, z towards the public.

export type Place = [number, number];

/** Most points of a line that the engine follows as it is drawn. */
export const MOST_POINTS = 512;

export function distance(a: Place, b: Place): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}

export function lengthOf(line: Place[]): number {
  let sum = 0;
  for (let at = 1; at < line.length; at++) sum += distance(line[at - 1] as Place, line[at] as Place);
  return sum;
}

/** Rounded to centimetres. */
export function roundPlace([x, z]: Place): Place {
  return [Math.round(x * 100) / 100, Math.round(z * 100) / 100];
}

/** Distance of a place from the straight line between two others [m]. */
export function awayFrom(place: Place, a: Place, b: Place): number {
  const dx = b[0] - a[0];
  const dz = b[1] - a[1];
  const square = dx * dx + dz * dz;
  const share = square > 0 ? Math.min(1, Math.max(0, ((place[0] - a[0]) * dx + (place[1] - a[1]) * dz) / square)) : 0;
  return Math.hypot(place[0] - a[0] - share * dx, place[1] - a[1] - share * dz);
}

/** A drawn line with fewer points, none farther than `tolerance` [m] from it (Ramer, Douglas, Peucker); it grows until `most` are enough. */
export function simplified(line: Place[], tolerance = 0.02, most = MOST_POINTS): Place[] {
  for (let near = tolerance; ; near *= 1.5) {
    const found = thinned(line, near);
    if (found.length <= Math.max(most, 2)) return found;
  }
}

function thinned(line: Place[], tolerance: number): Place[] {
  if (line.length < 3) return [...line];
  const kept = new Uint8Array(line.length);
  kept[0] = kept[line.length - 1] = 1;
  const spans: [number, number][] = [[0, line.length - 1]];
  for (let span = spans.pop(); span; span = spans.pop()) {
    const [first, last] = span;
    let farthest = tolerance;
    let at = 0;
    for (let point = first + 1; point < last; point++) {
      const away = awayFrom(line[point] as Place, line[first] as Place, line[last] as Place);
      if (away > farthest) [farthest, at] = [away, point];
    }
    if (!at) continue;
    kept[at] = 1;
    spans.push([first, at], [at, last]);
  }
  return line.filter((_, point) => kept[point]);
}

/** Whether a place lies within a closed line. */
export function isWithin([x, z]: Place, outline: Place[]): boolean {
  let inside = false;
  for (let at = 0, before = outline.length - 1; at < outline.length; before = at++) {
    const [ax, az] = outline[at] as Place;
    const [bx, bz] = outline[before] as Place;
    if (az > z !== bz > z && x < ((bx - ax) * (z - az)) / (bz - az) + ax) inside = !inside;
  }
  return inside;
}

/** Whether a freehand line ends near where it began. */
export function isClosed(line: Place[]): boolean {
  const first = line[0];
  const last = line.at(-1);
  return line.length > 3 && !!first && !!last && distance(first, last) < Math.max(0.25, 0.12 * lengthOf(line));
}

/** The nearest place in the direction (right, down) of another, by number; -1 if there is none. Those aside count as farther. */
export function nearestTowards(places: (Place | null)[], from: Place, right: number, down: number): number {
  let found = -1;
  let least = Infinity;
  places.forEach((place, index) => {
    if (!place) return;
    const along = (place[0] - from[0]) * right + (place[1] - from[1]) * down;
    const aside = Math.abs((place[0] - from[0]) * down - (place[1] - from[1]) * right);
    if (along < 0.05 || aside > 2 * along) return;
    const cost = along + 2 * aside;
    if (cost < least) [found, least] = [index, cost];
  });
  return found;
}

/** Pairs of places whose distance is shown: all of up to four, else of each the nearest one. */
export function pairsToMeasure(places: Place[]): [number, number][] {
  const pairs: [number, number][] = [];
  if (places.length <= 4) {
    for (let a = 0; a < places.length; a++) for (let b = a + 1; b < places.length; b++) pairs.push([a, b]);
    return pairs;
  }
  const known = new Set<string>();
  for (const [a, b] of places.map((_, index) => [index, nearestOf(places, index, 1)[0] ?? index] as const)) {
    const name = a < b ? `${a} ${b}` : `${b} ${a}`;
    if (a !== b && !known.has(name)) pairs.push([a, b]);
    known.add(name);
  }
  return pairs;
}

/** Where two ways of the same times are nearest to each other: the number of the point; -1 without any. */
export function nearestMoment(one: Place[], other: Place[]): number {
  let found = -1;
  let least = Infinity;
  for (let at = 0; at < Math.min(one.length, other.length); at++) {
    const away = distance(one[at] as Place, other[at] as Place);
    if (away < least) [found, least] = [at, away];
  }
  return found;
}

/** Numbers of the places nearest to one of them. */
export function nearestOf(places: Place[], index: number, count: number): number[] {
  const here = places[index] as Place;
  return places
    .map((place, other) => ({ other, away: distance(place, here) }))
    .filter(({ other }) => other !== index)
    .sort((a, b) => a.away - b.away)
    .slice(0, count)
    .map(({ other }) => other);
}

/** Numbers (from 1) in words of a selection: "1-3 + 7". */
export function numbersInWords(numbers: number[]): string {
  const sorted = [...new Set(numbers)].sort((a, b) => a - b);
  const parts: string[] = [];
  for (let at = 0; at < sorted.length; ) {
    let end = at;
    while (sorted[end + 1] === (sorted[end] as number) + 1) end++;
    parts.push(end > at ? `${sorted[at]}-${sorted[end]}` : String(sorted[at]));
    at = end + 1;
  }
  return parts.join(" + ");
}
