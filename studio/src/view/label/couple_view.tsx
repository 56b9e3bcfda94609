import { effect, type Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { HEAD_JOINT, PARENTS } from "../stage/skeleton";
import { loadSolid } from "../stage/load_solid";
import { coloursOf } from "../stage/solid_stage";
import type { SolidPicture } from "../stage/stage3d";

/** A take: joints in millimetres, samples x dancers x 22 x 3; the leader first. */
export interface CoupleMotion {
  take: string;
  samples: number;
  dancers: number;
  rate: number;
  width: number;
  depth: number;
  joints: Int16Array;
}

const TURN_PX = 0.008;
const AROUND_M = 1.6;
/** Of the leader, and of the follower. */
const COLOURS: [number, number, number][] = [[0.36, 0.55, 0.86], [0.9, 0.42, 0.28]];

/** Joints [m] of all dancers at a time, straight between two samples. */
function posed(motion: CoupleMotion, time: number, into: Float32Array): Float32Array {
  const size = motion.dancers * PARENTS.length * 3;
  const at = Math.min(Math.max(time * motion.rate, 0), motion.samples - 1);
  const low = Math.floor(at);
  const high = Math.min(low + 1, motion.samples - 1);
  for (let index = 0; index < size; index++) {
    const a = motion.joints[low * size + index] as number;
    into[index] = (a + (at - low) * ((motion.joints[high * size + index] as number) - a)) / 1000;
  }
  return into;
}

/** The couple in 3D, from any side: drag, wheel; in a browser without WebGL as lines, from the front. */
export function CoupleView({ motion, time }: { motion: Signal<CoupleMotion | null>; time: Signal<number> }) {
  const place = useRef<HTMLDivElement>(null);
  const picture = useRef<SolidPicture | null>(null);
  const held = useRef<[number, number] | null>(null);
  useEffect(() => {
    const element = place.current as HTMLDivElement;
    const stops: (() => void)[] = [];
    let gone = false;
    const begin = (draw: (joints: Float32Array, known: CoupleMotion) => void, fit: (known: CoupleMotion) => void): void => {
      let shown: CoupleMotion | null = null;
      let joints = new Float32Array(0);
      stops.push(effect(() => {
        const known = motion.value;
        const now = time.value;
        if (!known) return;
        if (known !== shown) {
          shown = known;
          joints = new Float32Array(known.dancers * PARENTS.length * 3);
          fit(known);
        }
        draw(posed(known, now, joints), known);
      }));
    };
    const lines = (): void => {
      const canvas = document.createElement("canvas");
      element.append(canvas);
      stops.push(() => canvas.remove());
      begin((joints, known) => paintLines(canvas, element, joints, known), () => {});
    };
    if (!document.createElement("canvas").getContext("webgl2")) lines();
    else {
      void loadSolid().then(({ SolidPicture }) => {
        if (gone) return;
        try {
          picture.current = new SolidPicture(element, coloursOf(element));
        } catch {
          lines();
          return;
        }
        const made = picture.current;
        const watch = new ResizeObserver(() => made.resize(element.clientWidth, element.clientHeight));
        watch.observe(element);
        stops.push(() => watch.disconnect(), () => made.dispose());
        const colours = new Float32Array(COLOURS.flat());
        begin((joints) => made.pose(joints, colours, null, new Set()), (known) => {
          made.surround({ width: known.width + AROUND_M, depth: known.depth + AROUND_M, obstacles: [] });
          made.look("free");
        });
      });
    }
    return () => {
      gone = true;
      for (const stop of stops) stop();
      picture.current = null;
    };
  }, []);
  return (
    <div
      ref={place} class="view" role="img" aria-label="The couple dances"
      onPointerDown={(event) => { event.currentTarget.setPointerCapture(event.pointerId); held.current = [event.clientX, event.clientY]; }}
      onPointerMove={(event) => {
        if (!held.current) return;
        picture.current?.orbit(-(event.clientX - held.current[0]) * TURN_PX, (event.clientY - held.current[1]) * TURN_PX);
        held.current = [event.clientX, event.clientY];
      }}
      onPointerUp={() => { held.current = null; }}
      onPointerCancel={() => { held.current = null; }}
      onWheel={(event) => { event.preventDefault(); picture.current?.orbit(0, 0, Math.exp(event.deltaY / 600)); }}
    />
  );
}

/** Bodies as lines, seen from the hall. */
function paintLines(canvas: HTMLCanvasElement, element: HTMLElement, joints: Float32Array, known: CoupleMotion): void {
  const [width, height] = [element.clientWidth, element.clientHeight];
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const context = canvas.getContext("2d");
  if (!context) return;
  context.clearRect(0, 0, width, height);
  const scale = Math.min(width / (known.width + AROUND_M), height / 2.4);
  const place = (at: number): [number, number] => [width / 2 + scale * (joints[at] as number), 0.9 * height - scale * ((joints[at + 1] as number) - 0.12 * (joints[at + 2] as number))];
  for (let dancer = 0; dancer < known.dancers; dancer++) {
    const [r, g, b] = COLOURS[dancer % 2] as [number, number, number];
    context.strokeStyle = context.fillStyle = `rgb(${255 * r} ${255 * g} ${255 * b})`;
    context.lineWidth = 5;
    context.lineCap = "round";
    const base = dancer * PARENTS.length * 3;
    context.beginPath();
    PARENTS.forEach((parent, joint) => {
      if (parent < 0) return;
      context.moveTo(...place(base + 3 * parent));
      context.lineTo(...place(base + 3 * joint));
    });
    context.stroke();
    context.beginPath();
    context.arc(...place(base + 3 * HEAD_JOINT), 0.11 * scale, 0, 2 * Math.PI);
    context.fill();
  }
}
