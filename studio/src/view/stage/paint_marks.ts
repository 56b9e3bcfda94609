// What lies on the stage besides its dancers: obstacles, gates, items, elements, distances, and what is drawn just now.
import { entries, number, text, type Entry } from "../../model/score";
import { distance, nearestMoment, nearestOf, pairsToMeasure, type Place } from "../../model/geometry";
import type { Positions } from "../../net/frames";
import { toPixels, type Camera2D } from "./camera2d";
import type { Scene } from "./paint";

type Context = CanvasRenderingContext2D;

const MOST_MEETINGS = 40;
/** Distances to the second and third neighbour are shown up to this [m]. */
const NEIGHBOUR_M = 2.5;

/** An element of the score that is selected, or acts in the measure that is looked at. */
export interface Written {
  kind: string;
  entry: Entry;
  selected: boolean;
}

function line(context: Context, camera: Camera2D, places: Place[], closed = false): void {
  context.beginPath();
  places.forEach(([x, z], index) => {
    const [px, py] = toPixels(camera, x, z);
    if (index) context.lineTo(px, py);
    else context.moveTo(px, py);
  });
  if (closed) context.closePath();
}

function disc(context: Context, camera: Camera2D, [x, z]: Place, radius: number): void {
  const [px, py] = toPixels(camera, x, z);
  context.beginPath();
  context.arc(px, py, radius, 0, 2 * Math.PI);
}

function label(context: Context, camera: Camera2D, words: string, px: number, py: number, colour: string): void {
  context.fillStyle = colour;
  context.font = "12px system-ui, sans-serif";
  const right = px > camera.width / 2;
  context.textAlign = right ? "right" : "left";
  context.fillText(words, px + (right ? -11 : 11), py + 4);
}

export function paintSet(context: Context, { camera, score, theme }: Scene): void {
  for (const entry of entries(score, "obstacle")) {
    const at = (entry["at"] as Place | undefined) ?? [0, 0];
    const wall = entry["wall_to"] as Place | undefined;
    context.strokeStyle = theme.dim;
    context.fillStyle = theme.line;
    if (wall) {
      context.lineWidth = 5;
      context.lineCap = "butt";
      line(context, camera, [at, wall]);
      context.stroke();
    } else {
      disc(context, camera, at, number(entry, "radius", 0.3) * camera.scale);
      context.fill();
      context.lineWidth = 1;
      context.stroke();
    }
  }
  for (const entry of entries(score, "item")) {
    const at = (entry["at"] as Place | undefined) ?? [0, 0];
    const [width, depth] = (entry["size"] as Place | undefined) ?? [number(entry, "width", 0.5), number(entry, "depth", 0.5)];
    const [px, py] = toPixels(camera, at[0], at[1]);
    context.strokeStyle = theme.dim;
    context.lineWidth = 1.5;
    context.strokeRect(px - (width * camera.scale) / 2, py - (depth * camera.scale) / 2, width * camera.scale, depth * camera.scale);
    label(context, camera, text(entry, "name"), px, py, theme.dim);
  }
  for (const entry of entries(score, "gate")) {
    const at = entry["at"] as Place | undefined;
    if (!at) continue;
    const [px, py] = toPixels(camera, at[0], at[1]);
    context.lineWidth = 3;
    context.strokeStyle = theme.accent;
    disc(context, camera, at, 7);
    context.stroke();
    label(context, camera, text(entry, "name"), px, py, theme.dim);
  }
  context.lineWidth = 1;
}

/** Elements that act now are filled, the selected ones of the score are outlines. */
export function paintElements(context: Context, { camera, elements, written, theme }: Scene): void {
  for (const element of elements) {
    const level = Math.min(1, Math.max(0, element.level));
    const radius = Math.max(element.radius, 0.35) * camera.scale;
    context.fillStyle = context.strokeStyle = theme.accent;
    disc(context, camera, element.at, radius);
    context.globalAlpha = 0.06 + 0.16 * level;
    context.fill();
    context.globalAlpha = 0.35 + 0.5 * level;
    context.lineWidth = 1.5;
    context.stroke();
    context.globalAlpha = 1;
    const [px, py] = toPixels(camera, element.at[0], element.at[1]);
    context.font = "12px system-ui, sans-serif";
    context.textAlign = "center";
    context.fillStyle = theme.ink;
    context.fillText(`${element.kind}, now`, px, py + radius + 14);
  }
  for (const { kind, entry, selected } of written) {
    const at = (entry["at"] as Place | undefined) ?? [0, 0];
    const to = entry["to"] as Place | undefined;
    const points = (entry["points"] ?? entry["path"]) as Place[] | undefined;
    context.strokeStyle = theme.accent;
    context.lineWidth = selected ? 2 : 1.25;
    context.globalAlpha = selected ? 1 : 0.7;
    context.setLineDash([7, 4]);
    if (points && Array.isArray(points[0])) line(context, camera, points, entry["closed"] === true);
    else if (to) line(context, camera, [at, to]);
    else if (kind === "formation" || ["spread", "wander", "flock"].includes(kind)) context.beginPath();
    else disc(context, camera, at, Math.max(number(entry, "radius", 0), 0.5) * camera.scale);
    context.stroke();
    context.setLineDash([]);
    context.globalAlpha = 1;
  }
  context.lineWidth = 1;
}

/** Regions and lines to which what is dragged can be bent; the one under it is full. */
export function paintGrounds(context: Context, { camera, grounds, target, theme }: Scene): void {
  for (const ground of grounds) {
    const isTarget = ground === target;
    context.strokeStyle = context.fillStyle = isTarget ? theme.accent : theme.dim;
    context.lineWidth = isTarget ? 3 : 1.5;
    context.setLineDash(isTarget ? [] : [6, 4]);
    context.beginPath();
    for (const places of ground.lines) {
      places.forEach(([x, z], index) => {
        const [px, py] = toPixels(camera, x, z);
        if (index) context.lineTo(px, py);
        else context.moveTo(px, py);
      });
    }
    if (ground.kind === "into") {
      context.globalAlpha = isTarget ? 0.16 : 0.05;
      context.fill("evenodd");
    }
    context.globalAlpha = isTarget ? 1 : 0.7;
    context.stroke();
    context.globalAlpha = 1;
    context.setLineDash([]);
    const first = ground.lines[0]?.[0];
    if (first && typeof ground.to === "string") label(context, camera, ground.to, ...toPixels(camera, first[0], first[1]), isTarget ? theme.accent : theme.dim);
  }
  context.lineWidth = 1;
}

/** Marks where two would meet: the places of their ways where they are nearest to each other. */
export function paintMeetings(context: Context, { camera, meetings, ways, theme }: Scene): void {
  if (!ways) return;
  context.strokeStyle = context.fillStyle = theme.alarm;
  context.lineWidth = 2;
  for (const [a, b] of meetings.slice(0, MOST_MEETINGS)) {
    const one = ways.ways[ways.dancers.indexOf(a)];
    const other = ways.ways[ways.dancers.indexOf(b)];
    const at = one && other ? nearestMoment(one, other) : -1;
    if (at < 0) continue;
    const places = [one?.[at] as Place, other?.[at] as Place];
    line(context, camera, places);
    context.stroke();
    for (const place of places) {
      disc(context, camera, place, 3.5);
      context.fill();
    }
  }
  context.lineWidth = 1;
}

export function placeIn(positions: Positions, dancer: number): Place {
  return [positions.rows[3 * (dancer - 1)] ?? 0, positions.rows[3 * (dancer - 1) + 1] ?? 0];
}

export function paintDistances(context: Context, scene: Scene): void {
  const { camera, positions, theme } = scene;
  const measure = (a: Place, b: Place, colour: string): void => {
    context.strokeStyle = colour;
    context.lineWidth = 1;
    context.setLineDash([3, 3]);
    line(context, camera, [a, b]);
    context.stroke();
    context.setLineDash([]);
    const [px, py] = toPixels(camera, (a[0] + b[0]) / 2, (a[1] + b[1]) / 2);
    const words = `${distance(a, b).toFixed(2)} m`;
    context.font = "600 12px system-ui, sans-serif";
    context.textAlign = "center";
    const wide = context.measureText(words).width + 8;
    context.fillStyle = theme.floor;
    context.globalAlpha = 0.85;
    context.fillRect(px - wide / 2, py - 9, wide, 18);
    context.globalAlpha = 1;
    context.fillStyle = theme.ink;
    context.fillText(words, px, py + 4);
  };
  if (scene.distances && positions && scene.chosen.size > 1) {
    const places = [...scene.chosen].filter((one) => positions.present[one - 1]).map((one) => placeIn(positions, one));
    for (const [a, b] of pairsToMeasure(places)) measure(places[a] as Place, places[b] as Place, theme.ink);
  }
  const { held, stage } = scene;
  if (!held) return;
  const others = scene.places.length ? scene.places.filter((one) => distance(one, held) > 0.005) : standing(scene.ghost ?? positions).filter((one) => distance(one, held) > 0.01);
  nearestOf([held, ...others], 0, 3).forEach((near, rank) => {
    const other = others[near - 1] as Place;
    if (rank === 0 || distance(other, held) < NEIGHBOUR_M) measure(held, other, theme.ink);
  });
  measure(held, [0, held[1]], theme.accent);
  measure(held, [(Math.sign(held[0]) || 1) * (stage.width / 2), held[1]], theme.dim);
  measure(held, [held[0], (Math.sign(held[1]) || 1) * (stage.depth / 2)], theme.dim);
}

function standing(positions: Positions | null): Place[] {
  if (!positions) return [];
  return Array.from({ length: positions.count }, (_, row) => row + 1).filter((one) => positions.present[one - 1]).map((one) => placeIn(positions, one));
}

export function paintSketch(context: Context, { camera, sketch, pen, places, theme }: Scene): void {
  for (const place of places) {
    disc(context, camera, place, 0.16 * camera.scale);
    context.strokeStyle = theme.accent;
    context.lineWidth = 1.5;
    context.stroke();
  }
  if (sketch && sketch.points.length > 1) {
    context.strokeStyle = theme.accent;
    context.fillStyle = theme.accent;
    context.lineWidth = sketch.kind === "line" ? 2.5 : 1;
    line(context, camera, sketch.points, sketch.closed);
    if (sketch.closed) {
      context.globalAlpha = 0.1;
      context.fill();
      context.globalAlpha = 1;
    }
    context.stroke();
  } else if (sketch?.points[0]) {
    disc(context, camera, sketch.points[0], 3);
    context.fillStyle = theme.accent;
    context.fill();
  }
  if (pen) {
    const [px, py] = toPixels(camera, pen[0], pen[1]);
    context.strokeStyle = theme.accent;
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(px - 12, py);
    context.lineTo(px + 12, py);
    context.moveTo(px, py - 12);
    context.lineTo(px, py + 12);
    context.stroke();
  }
  context.lineWidth = 1;
}
