import { useEffect, useRef, useState } from "preact/hooks";
import { beatNow, extentOf, HEAD, HEAD_M, LIMBS, poseAt, seen, type Extent, type Look, type Motion } from "../../model/figure";
import type { Studio } from "../../model/studio";
import { coloursOf, fitCanvas, isCalm, whileSeen } from "../../ui/animation";

/** A dancer who dances a step on the beat of the show; several motions lie over each other. `still`: the hips stay. */
export function Figure({ studio, motions, look, still, label }: { studio: Studio; motions: Motion[]; look: Look; still?: boolean; label?: string }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const element = canvas.current as HTMLCanvasElement;
    const context = element.getContext("2d") as CanvasRenderingContext2D;
    const extent = joined(motions.map((motion) => extentOf(motion, look, still === true)));
    const names = ["ink", "dim", "line", "left", "right", "accent"];
    let colours = coloursOf(element, names);
    const light = window.matchMedia("(prefers-color-scheme: light)");
    const onLight = (): void => { colours = coloursOf(element, names); };
    light.addEventListener("change", onLight);
    const pose = new Float32Array(66);
    const stop = whileSeen(element, (now) => {
      const [width, height] = fitCanvas(element, context);
      const beat = isCalm() ? (motions[0]?.beats ?? 0) / 2 : beatNow(studio.doc.clock.peek(), studio.library.heard, now, studio.beats.peek());
      const scale = Math.min(width / (extent.right - extent.left), height / (extent.bottom - extent.top));
      context.save();
      context.translate(width / 2 - (scale * (extent.left + extent.right)) / 2, height / 2 - (scale * (extent.top + extent.bottom)) / 2);
      context.scale(scale, scale);
      if (look !== "above") floor(context, extent, colours["line"] ?? "");
      motions.forEach((motion, index) => {
        context.globalAlpha = index ? 0.6 : 1;
        dancer(context, poseAt(motion, beat, pose), look, still === true, index ? { ink: colours["accent"] ?? "", left: colours["accent"] ?? "", right: colours["accent"] ?? "" } : (colours as unknown as Colours));
      });
      context.restore();
    });
    return () => {
      stop();
      light.removeEventListener("change", onLight);
    };
  }, [studio, motions, look, still]);
  return <canvas ref={canvas} class="figure" {...(label ? { role: "img", "aria-label": label } : { "aria-hidden": true })} />;
}

/** The figure of a step; its motion is asked for when it is seen. */
export function SmallFigure({ studio, name }: { studio: Studio; name: string }) {
  const place = useRef<HTMLSpanElement>(null);
  const [motions, setMotions] = useState<Motion[] | null>(null);
  const { library } = studio.doc.structure.value ?? {};
  useEffect(() => {
    let left = false;
    const watch = new IntersectionObserver((entries) => {
      if (!entries.at(-1)?.isIntersecting) return;
      watch.disconnect();
      void studio.library.motion(name).then((found) => { if (!left && found.length) setMotions(found); });
    });
    watch.observe(place.current as HTMLElement);
    return () => {
      left = true;
      watch.disconnect();
    };
  }, [studio, name, library]);
  return <span ref={place} class="small">{motions && <Figure studio={studio} motions={motions} look="front" still />}</span>;
}

interface Colours {
  ink: string;
  left: string;
  right: string;
}

function joined(extents: Extent[]): Extent {
  return extents.reduce((a, b) => ({
    left: Math.min(a.left, b.left), top: Math.min(a.top, b.top), right: Math.max(a.right, b.right), bottom: Math.max(a.bottom, b.bottom),
  }), extents[0] ?? { left: -1, top: -1.9, right: 1, bottom: 0.1 });
}

function floor(context: CanvasRenderingContext2D, extent: Extent, colour: string): void {
  context.strokeStyle = colour;
  context.lineWidth = 0.015;
  context.beginPath();
  context.moveTo(extent.left, 0);
  context.lineTo(extent.right, 0);
  context.stroke();
}

function dancer(context: CanvasRenderingContext2D, pose: Float32Array, look: Look, still: boolean, colours: Colours): void {
  const [hx, hz] = still ? [pose[0] ?? 0, pose[2] ?? 0] : [0, 0];
  const at = (joint: number): [number, number] => seen(look, (pose[3 * joint] ?? 0) - hx, pose[3 * joint + 1] ?? 0, (pose[3 * joint + 2] ?? 0) - hz);
  context.lineCap = "round";
  context.lineJoin = "round";
  for (const limb of LIMBS) {
    context.strokeStyle = limb.side ? colours[limb.side] : colours.ink;
    context.lineWidth = limb.width;
    context.beginPath();
    limb.joints.forEach((joint, index) => (index ? context.lineTo(...at(joint)) : context.moveTo(...at(joint))));
    context.stroke();
  }
  context.fillStyle = colours.ink;
  context.beginPath();
  context.arc(...at(HEAD), HEAD_M, 0, 2 * Math.PI);
  context.fill();
}
