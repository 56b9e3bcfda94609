// The picture of the stage from above, drawn on a canvas.
import type { Group, Score } from "../../model/score";
import { entries, number, text } from "../../model/score";
import type { StageElement, Ways } from "../../model/document";
import type { Positions } from "../../net/frames";
import { toPixels, type Camera2D } from "./camera2d";

export interface Theme {
  floor: string;
  line: string;
  ink: string;
  dim: string;
  accent: string;
  alarm: string;
}

export interface Scene {
  camera: Camera2D;
  stage: { width: number; depth: number };
  score: Score;
  groups: Group[];
  /** Group of each dancer. */
  groupOf: Int16Array;
  positions: Positions | null;
  ghost: Positions | null;
  ways: Ways | null;
  elements: StageElement[];
  chosen: ReadonlySet<number>;
  /** Dancers who would meet somebody, or cannot get there, from 1. */
  alarmed: ReadonlySet<number>;
  names: boolean;
  theme: Theme;
}

const BODY_M = 0.24;

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
  if (scene.ways) paintWays(context, scene, scene.ways);
  if (scene.ghost) paintDancers(context, scene, scene.ghost, 0.28);
  if (scene.positions) paintDancers(context, scene, scene.positions, 1);
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

function paintSet(context: CanvasRenderingContext2D, { camera, score, theme }: Scene): void {
  context.strokeStyle = theme.dim;
  context.fillStyle = theme.line;
  for (const entry of entries(score, "obstacle")) {
    const [x, z] = (entry["at"] as [number, number]) ?? [0, 0];
    const [px, py] = toPixels(camera, x, z);
    const wall = entry["wall_to"] as [number, number] | undefined;
    context.beginPath();
    if (wall) {
      context.lineWidth = 4;
      context.moveTo(px, py);
      context.lineTo(...toPixels(camera, wall[0], wall[1]));
      context.stroke();
    } else {
      context.arc(px, py, number(entry, "radius", 0.3) * camera.scale, 0, 2 * Math.PI);
      context.fill();
    }
  }
  context.lineWidth = 3;
  context.strokeStyle = theme.accent;
  for (const entry of entries(score, "gate")) {
    const at = entry["at"] as [number, number] | undefined;
    if (!at) continue;
    const [px, py] = toPixels(camera, at[0], at[1]);
    context.beginPath();
    context.arc(px, py, 7, 0, 2 * Math.PI);
    context.stroke();
    context.fillStyle = theme.dim;
    context.textAlign = px < camera.width / 2 ? "left" : "right";
    context.fillText(text(entry, "name"), px + (px < camera.width / 2 ? 11 : -11), py + 4);
  }
  context.lineWidth = 1;
}

function paintElements(context: CanvasRenderingContext2D, { camera, elements, theme }: Scene): void {
  for (const element of elements) {
    const [px, py] = toPixels(camera, element.at[0], element.at[1]);
    const radius = Math.max(element.radius, 0.3) * camera.scale;
    context.globalAlpha = 0.15 + 0.5 * Math.min(1, Math.max(0, element.level));
    context.strokeStyle = theme.accent;
    context.beginPath();
    context.arc(px, py, radius, 0, 2 * Math.PI);
    context.stroke();
    context.globalAlpha = 1;
  }
}

function paintWays(context: CanvasRenderingContext2D, scene: Scene, ways: Ways): void {
  const { camera } = scene;
  context.lineWidth = 2;
  context.lineCap = "round";
  ways.ways.forEach((way, index) => {
    const dancer = ways.dancers[index] ?? index + 1;
    const group = scene.groups[scene.groupOf[dancer - 1] ?? 0];
    const first = way[0];
    const last = way.at(-1);
    if (!first || !last || Math.hypot(last[0] - first[0], last[1] - first[1]) < 0.02) return;
    const steps = Math.max(way.length - 1, 1);
    for (let at = 0; at < steps; at += 4) {
      // pale at the start, full at the end
      context.globalAlpha = 0.12 + (0.78 * (at + 4)) / steps;
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
    context.globalAlpha = 0.9;
    context.beginPath();
    context.arc(px, py, 0.5 * BODY_M * camera.scale, 0, 2 * Math.PI);
    context.stroke();
  });
  context.globalAlpha = 1;
  context.lineWidth = 1;
}

function paintDancers(context: CanvasRenderingContext2D, scene: Scene, positions: Positions, alpha: number): void {
  const { camera, theme } = scene;
  const radius = Math.max(BODY_M * camera.scale, 3);
  context.font = `600 ${Math.round(Math.max(9, Math.min(13, radius)))}px system-ui, sans-serif`;
  context.textAlign = "center";
  for (let row = 0; row < positions.count; row++) {
    if (!positions.present[row]) continue;
    const [px, py] = toPixels(camera, positions.rows[3 * row] ?? 0, positions.rows[3 * row + 1] ?? 0);
    const heading = positions.rows[3 * row + 2] ?? 0;
    const group = scene.groups[scene.groupOf[row] ?? 0];
    context.globalAlpha = alpha;
    context.fillStyle = colourOf(group);
    context.beginPath();
    context.arc(px, py, radius, 0, 2 * Math.PI);
    context.fill();
    if (alpha === 1 && (scene.chosen.has(row + 1) || scene.alarmed.has(row + 1))) {
      context.strokeStyle = scene.alarmed.has(row + 1) ? theme.alarm : theme.ink;
      context.lineWidth = 2.5;
      context.beginPath();
      context.arc(px, py, radius + 3, 0, 2 * Math.PI);
      context.stroke();
      context.lineWidth = 1;
    }
    // a triangle within the circle: where they look; heading 0 faces the public, positive towards +x
    const dx = Math.sin(heading);
    const dy = Math.cos(heading);
    context.fillStyle = "rgb(0 0 0 / 0.72)";
    context.beginPath();
    context.moveTo(px + dx * radius * 0.86, py + dy * radius * 0.86);
    context.lineTo(px - dx * radius * 0.45 + dy * radius * 0.55, py - dy * radius * 0.45 - dx * radius * 0.55);
    context.lineTo(px - dx * radius * 0.45 - dy * radius * 0.55, py - dy * radius * 0.45 + dx * radius * 0.55);
    context.fill();
    if (scene.names && alpha === 1) {
      context.fillStyle = theme.dim;
      context.fillText(String(row + 1), px, py - radius - 5);
    }
  }
  context.globalAlpha = 1;
}
