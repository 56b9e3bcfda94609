import { useEffect, useRef } from "preact/hooks";
import { alongWay, type OptionFigures } from "../../model/gap";
import { stageSize } from "../../model/plan";
import type { Studio } from "../../model/studio";
import { coloursOf, fitCanvas, isCalm, onFrames } from "../../ui/animation";
import { colourOf } from "../stage/paint";
import { groupOf } from "../stage/stage_view";
import { toMetres, toPixels, type Camera2D } from "../stage/camera2d";

const PASS_MS = 2600;
const REST_MS = 700;
const BODY_M = 0.24;

const MARGIN_M = 0.2;

function cameraOf(width: number, height: number, stage: { width: number; depth: number }): Camera2D {
  return { width, height, scale: Math.max(1, Math.min(width / (stage.width + 2 * MARGIN_M), height / (stage.depth + 2 * MARGIN_M))) };
}

interface Drawn {
  studio: Studio;
  dancers: number[];
  figures: OptionFigures;
  /** Where each dancer goes when linked by hand (rows of places); null: as planned. */
  linked?: { places: [number, number][]; of: number[]; held: number | null } | null;
  label: string;
  onPress?: (x: number, z: number) => void;
}

/** The ways of an option: pale at the start, full at the end, and the dancers on them, again and again. */
export function WayPicture({ studio, dancers, figures, linked, label, onPress }: Drawn) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const size = stageSize(studio.score.value);
  useEffect(() => {
    const element = canvas.current as HTMLCanvasElement;
    const context = element.getContext("2d") as CanvasRenderingContext2D;
    const colours = coloursOf(element, ["floor", "line", "ink", "alarm", "accent"]);
    const groups = studio.doc.structure.peek()?.groups ?? [];
    const group = groupOf(studio, Math.max(...dancers, 0));
    const alarmed = new Set([...figures.meetings.flatMap((one) => one.dancers), ...figures.too_far.map((one) => one.dancer)]);
    const ways = linked ? figures.ways.map((way, row): [number, number][] => [way[0] ?? [0, 0], linked.places[linked.of[row] ?? 0] ?? [0, 0]]) : figures.ways;
    const colour = (row: number): string => (!linked && alarmed.has(dancers[row] ?? 0) ? (colours["alarm"] ?? "") : colourOf(groups[group[(dancers[row] ?? 1) - 1] ?? 0]));
    const draw = (now: number): void => {
      const [width, height] = fitCanvas(element, context);
      const stage = stageSize(studio.score.peek());
      const camera = cameraOf(width, height, stage);
      const share = isCalm() ? 1 : Math.min((now % (PASS_MS + REST_MS)) / PASS_MS, 1);
      const [left, top] = toPixels(camera, -stage.width / 2, -stage.depth / 2);
      context.fillStyle = colours["floor"] ?? "";
      context.strokeStyle = colours["line"] ?? "";
      context.fillRect(left, top, stage.width * camera.scale, stage.depth * camera.scale);
      context.strokeRect(left, top, stage.width * camera.scale, stage.depth * camera.scale);
      context.lineWidth = 1.6;
      context.lineCap = "round";
      ways.forEach((way, row) => {
        context.strokeStyle = colour(row);
        const pieces = Math.min(8, Math.max(way.length - 1, 1));
        for (let piece = 0; piece < pieces; piece++) {
          context.globalAlpha = 0.12 + (0.7 * (piece + 1)) / pieces;
          context.beginPath();
          for (let point = 0; point <= 4; point++) {
            const [px, py] = toPixels(camera, ...alongWay(way, (piece + point / 4) / pieces));
            if (point) context.lineTo(px, py);
            else context.moveTo(px, py);
          }
          context.stroke();
        }
      });
      context.globalAlpha = 1;
      for (const [x, z] of linked?.places ?? []) {
        const [px, py] = toPixels(camera, x, z);
        context.strokeStyle = colours["accent"] ?? "";
        context.beginPath();
        context.arc(px, py, BODY_M * camera.scale + 2, 0, 2 * Math.PI);
        context.stroke();
      }
      ways.forEach((way, row) => {
        const [px, py] = toPixels(camera, ...(linked ? (way[0] ?? [0, 0]) : alongWay(way, share)));
        context.fillStyle = colour(row);
        context.beginPath();
        context.arc(px, py, Math.max(BODY_M * camera.scale, 2.5), 0, 2 * Math.PI);
        context.fill();
        if (linked) {
          context.fillStyle = "rgb(0 0 0 / 0.85)";
          context.font = "600 12px system-ui, sans-serif";
          context.textAlign = "center";
          context.fillText(String(dancers[row] ?? ""), px, py + 4);
        }
        if (linked?.held === row) {
          context.strokeStyle = colours["ink"] ?? "";
          context.lineWidth = 2.5;
          context.stroke();
          context.lineWidth = 1.6;
        }
      });
    };
    if (isCalm() || linked) {
      const once = requestAnimationFrame(() => draw(performance.now()));
      return () => cancelAnimationFrame(once);
    }
    return onFrames(draw);
  }, [studio, figures, dancers, linked]);
  return (
    <canvas
      ref={canvas}
      class="ways"
      style={{ aspectRatio: String((size.width + 2 * MARGIN_M) / (size.depth + 2 * MARGIN_M)) }}
      role="img"
      aria-label={label}
      onPointerDown={(event) => {
        if (!onPress) return;
        const box = event.currentTarget.getBoundingClientRect();
        onPress(...toMetres(cameraOf(box.width, box.height, stageSize(studio.score.peek())), event.clientX - box.left, event.clientY - box.top));
      }}
    />
  );
}
