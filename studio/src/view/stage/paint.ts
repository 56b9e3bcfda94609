// The picture of the stage from above, drawn on a canvas.
import type { Group, Score } from "../../model/score";
import type { StageElement, Ways } from "../../model/document";
import type { Place } from "../../model/geometry";
import type { Ground } from "../../model/material";
import type { Labels } from "../../model/stage_state";
import type { Positions } from "../../net/frames";
import { toPixels, type Camera2D } from "./camera2d";
import { paintDistances, paintElements, paintGrounds, paintMeetings, paintSet, paintSketch, type Written } from "./paint_marks";

export interface Theme {
  floor: string;
  line: string;
  ink: string;
  dim: string;
  accent: string;
  alarm: string;
  /** The value of a colour of the style sheet, by its name. */
  named: (name: string) => string;
}

/** What is drawn at this moment: a line, a shape, or the outline of a selection. */
export interface Sketch {
  points: Place[];
  closed: boolean;
  kind: "line" | "select";
}

export interface Scene {
  camera: Camera2D;
  stage: { width: number; depth: number };
  score: Score;
  groups: Group[];
  /** Group of each dancer. */
  groupOf: Int16Array;
  positions: Positions | null;
  /** Where everybody will be. */
  ghost: Positions | null;
  /** The stage's own picture, while a preview is shown; pale. */
  compared: Positions | null;
  ways: Ways | null;
  /** Whose ways are drawn or dragged just now; those of the others are dashed. Empty: all alike. */
  own: ReadonlySet<number>;
  /** Where what is dragged can be dropped, and where it would be now. */
  grounds: Ground[];
  target: Ground | null;
  /** Those that act now, and those that are selected in the score. */
  elements: StageElement[];
  written: Written[];
  chosen: ReadonlySet<number>;
  /** Dancers, from 1, that others have selected, with the names of their colours. */
  others: ReadonlyMap<number, string>;
  /** Dancers who would meet somebody, or cannot get there, from 1. */
  alarmed: ReadonlySet<number>;
  meetings: [number, number][];
  /** The dancer that the keyboard stands on; 0: none. */
  focus: number;
  labels: Labels;
  distances: boolean;
  /** A place that is dragged: its distances to the others are shown. */
  held: Place | null;
  /** Places that are put by hand, or of a formation that is thought of. */
  places: Place[];
  sketch: Sketch | null;
  pen: Place | null;
  theme: Theme;
}

export const BODY_M = 0.24;

export function colourOf(group: Group | undefined, alpha = 1): string {
  const [r, g, b] = group?.colour ?? [0.6, 0.6, 0.6];
  const channel = (value: number): number => Math.round(255 * Math.min(1, Math.max(0, value)) ** (1 / 2.2));
  return `rgb(${channel(r)} ${channel(g)} ${channel(b)} / ${alpha})`;
}

export function paint(context: CanvasRenderingContext2D, scene: Scene): void {
  const { camera } = scene;
  context.clearRect(0, 0, camera.width, camera.height);
  paintFloor(context, scene);
  paintSet(context, scene);
  paintElements(context, scene);
  paintGrounds(context, scene);
  if (scene.compared) paintPale(context, scene, scene.compared);
  if (scene.ways) paintWays(context, scene, scene.ways);
  if (scene.ghost) paintGhost(context, scene, scene.ghost);
  if (scene.positions) paintDancers(context, scene, scene.positions);
  paintMeetings(context, scene);
  paintDistances(context, scene);
  paintSketch(context, scene);
}

function paintFloor(context: CanvasRenderingContext2D, { camera, stage, theme }: Scene): void {
  const [left, top] = toPixels(camera, -stage.width / 2, -stage.depth / 2);
  const width = stage.width * camera.scale;
  const height = stage.depth * camera.scale;
  context.fillStyle = theme.floor;
  context.fillRect(left, top, width, height);
  context.strokeStyle = theme.line;
  context.lineWidth = 1;
  context.beginPath();
  for (let x = Math.ceil(-stage.width / 2); x <= stage.width / 2; x++) {
    const [px] = toPixels(camera, x, 0);
    context.moveTo(px, top);
    context.lineTo(px, top + height);
  }
  for (let z = Math.ceil(-stage.depth / 2); z <= stage.depth / 2; z++) {
    const [, py] = toPixels(camera, 0, z);
    context.moveTo(left, py);
    context.lineTo(left + width, py);
  }
  context.globalAlpha = 0.35;
  context.stroke();
  context.globalAlpha = 1;
  context.strokeRect(left, top, width, height);
  const [cx] = toPixels(camera, 0, 0);
  context.setLineDash([4, 4]);
  context.beginPath();
  context.moveTo(cx, top);
  context.lineTo(cx, top + height);
  context.stroke();
  context.setLineDash([]);
  context.fillStyle = theme.dim;
  context.font = "12px system-ui, sans-serif";
  context.textAlign = "center";
  context.fillText("public", cx, top + height + 20);
}

function paintWays(context: CanvasRenderingContext2D, scene: Scene, ways: Ways): void {
  const { camera } = scene;
  context.lineWidth = 2;
  context.lineCap = "butt";
  ways.ways.forEach((way, index) => {
    const dancer = ways.dancers[index] ?? index + 1;
    const group = scene.groups[(scene.positions?.present[dancer - 1] ?? 0) - 1];
    if (!group) return; // those who wait in the wings
    const first = way[0];
    const last = way.at(-1);
    if (!first || !last || Math.hypot(last[0] - first[0], last[1] - first[1]) < 0.02) return;
    const steps = Math.max(way.length - 1, 1);
    const isOther = scene.own.size > 0 && !scene.own.has(dancer);
    context.lineWidth = isOther ? 1.5 : 2;
    context.setLineDash(isOther ? [5, 4] : []);
    for (let at = 0; at < steps; at += 4) {
      // pale at the start, full at the end
      context.globalAlpha = 0.12 + (0.78 * (at + 4)) / steps;
      context.lineDashOffset = isOther ? at : 0; // one row of dashes across the pieces
      context.strokeStyle = scene.alarmed.has(dancer) ? scene.theme.alarm : colourOf(group);
      context.beginPath();
      for (let point = at; point <= Math.min(at + 4, steps); point++) {
        const place = way[point] as [number, number];
        const [px, py] = toPixels(camera, place[0], place[1]);
        if (point === at) context.moveTo(px, py);
        else context.lineTo(px, py);
      }
      context.stroke();
    }
    const [px, py] = toPixels(camera, last[0], last[1]);
    context.setLineDash([]);
    if (scene.ghost) return; // it shows where they arrive
    context.globalAlpha = 0.9;
    context.beginPath();
    context.arc(px, py, 0.5 * BODY_M * camera.scale, 0, 2 * Math.PI);
    context.stroke();
  });
  context.globalAlpha = 1;
  context.lineWidth = 1;
}

/** Where they are now, while the stage shows another moment: small pale circles. */
function paintPale(context: CanvasRenderingContext2D, scene: Scene, positions: Positions): void {
  const radius = Math.max(0.6 * BODY_M * scene.camera.scale, 2);
  context.globalAlpha = 0.4;
  for (let row = 0; row < positions.count; row++) {
    if (!positions.present[row]) continue;
    const [px, py] = toPixels(scene.camera, positions.rows[3 * row] ?? 0, positions.rows[3 * row + 1] ?? 0);
    context.fillStyle = colourOf(scene.groups[(positions.present[row] ?? 1) - 1]);
    context.beginPath();
    context.arc(px, py, radius, 0, 2 * Math.PI);
    context.fill();
  }
  context.globalAlpha = 1;
}

/** Where they will be: outlines. */
function paintGhost(context: CanvasRenderingContext2D, scene: Scene, positions: Positions): void {
  const radius = Math.max(BODY_M * scene.camera.scale, 3);
  context.lineWidth = 1.5;
  context.setLineDash([3, 2.5]);
  for (let row = 0; row < positions.count; row++) {
    if (!positions.present[row]) continue;
    const [px, py] = toPixels(scene.camera, positions.rows[3 * row] ?? 0, positions.rows[3 * row + 1] ?? 0);
    context.strokeStyle = scene.alarmed.has(row + 1) ? scene.theme.alarm : colourOf(scene.groups[(positions.present[row] ?? 1) - 1]);
    context.globalAlpha = 0.85;
    context.beginPath();
    context.arc(px, py, radius, 0, 2 * Math.PI);
    context.stroke();
    triangle(context, px, py, positions.rows[3 * row + 2] ?? 0, 0.75 * radius);
    context.fillStyle = context.strokeStyle;
    context.globalAlpha = 0.5;
    context.fill();
  }
  context.setLineDash([]);
  context.globalAlpha = 1;
  context.lineWidth = 1;
}

/** The path of a triangle that points where they look; heading 0 faces the public, positive towards +x. */
function triangle(context: CanvasRenderingContext2D, px: number, py: number, heading: number, radius: number): void {
  const dx = Math.sin(heading) * radius;
  const dy = Math.cos(heading) * radius;
  context.beginPath();
  context.moveTo(px + dx * 0.9, py + dy * 0.9);
  context.lineTo(px - dx * 0.45 + dy * 0.6, py - dy * 0.45 - dx * 0.6);
  context.lineTo(px - dx * 0.45 - dy * 0.6, py - dy * 0.45 + dx * 0.6);
  context.closePath();
}

function ring(context: CanvasRenderingContext2D, px: number, py: number, radius: number, colour: string, width: number): void {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  context.arc(px, py, radius, 0, 2 * Math.PI);
  context.stroke();
  context.lineWidth = 1;
}

function paintDancers(context: CanvasRenderingContext2D, scene: Scene, positions: Positions): void {
  const { camera, theme } = scene;
  const radius = Math.max(BODY_M * camera.scale, 3);
  context.font = `600 ${Math.round(Math.max(10, Math.min(13, radius)))}px system-ui, sans-serif`;
  context.textAlign = "center";
  for (let row = 0; row < positions.count; row++) {
    if (!positions.present[row]) continue;
    const [px, py] = toPixels(camera, positions.rows[3 * row] ?? 0, positions.rows[3 * row + 1] ?? 0);
    const dancer = row + 1;
    context.fillStyle = colourOf(scene.groups[(positions.present[row] ?? 1) - 1]);
    context.beginPath();
    context.arc(px, py, radius, 0, 2 * Math.PI);
    context.fill();
    if (scene.alarmed.has(dancer)) ring(context, px, py, radius + 2.5, theme.alarm, 2.5);
    if (scene.chosen.has(dancer)) ring(context, px, py, radius + (scene.alarmed.has(dancer) ? 6 : 3), theme.ink, 2.5);
    const other = scene.others.get(dancer);
    if (other) ring(context, px, py, radius + 5.5, theme.named(other), 2);
    if (scene.focus === dancer) ring(context, px, py, radius + 8, theme.accent, 2);
    context.fillStyle = "rgb(0 0 0 / 0.72)";
    triangle(context, px, py, positions.rows[3 * row + 2] ?? 0, radius);
    context.fill();
    if (scene.labels !== "none") {
      context.fillStyle = theme.ink;
      const below = scene.labels === "names" && dancer % 2 === 0; // by turns, so that neighbours have room
      context.fillText(scene.labels === "numbers" ? String(dancer) : nameOf(scene, dancer), px, below ? py + radius + 14 : py - radius - 6);
    }
  }
}

/** A dancer's group, and their number in it. */
function nameOf({ groups, groupOf }: Scene, dancer: number): string {
  const group = groupOf[dancer - 1] ?? -1;
  return group < 0 ? String(dancer) : `${groups[group]?.name ?? ""} ${dancer - groupOf.indexOf(group)}`;
}
