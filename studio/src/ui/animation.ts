// One loop for all moving pictures of the page: at most thirty frames a second, none while nothing moves.

const FRAME_MS = 30;
const drawers = new Set<(now: number) => void>();
const calm = window.matchMedia("(prefers-reduced-motion: reduce)");
let asked = 0;
let last = 0;

/** Whether this person wants pictures that do not move by themselves. */
export function isCalm(): boolean {
  return calm.matches;
}

function frame(now: number): void {
  asked = drawers.size ? requestAnimationFrame(frame) : 0;
  if (now - last < FRAME_MS) return;
  last = now;
  for (const draw of drawers) draw(now);
}

/** Call `draw` with the time [ms] of each frame, until the returned function is called. */
export function onFrames(draw: (now: number) => void): () => void {
  drawers.add(draw);
  if (!asked) asked = requestAnimationFrame(frame);
  return () => drawers.delete(draw);
}

/** Draw an element while it is seen: moving, or once for those who want it calm. Returns what ends it. */
export function whileSeen(element: Element, draw: (now: number) => void): () => void {
  let stop: (() => void) | null = null;
  const watch = new IntersectionObserver((entries) => {
    const seen = entries.at(-1)?.isIntersecting === true;
    stop?.();
    stop = null;
    if (!seen) return;
    if (isCalm()) draw(performance.now());
    else stop = onFrames(draw);
  });
  watch.observe(element);
  return () => {
    watch.disconnect();
    stop?.();
  };
}

/** Fit a canvas to its place on the page; returns its size there [px]. */
export function fitCanvas(canvas: HTMLCanvasElement, context: CanvasRenderingContext2D): [number, number] {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return [width, height];
}

/** Colours of the style sheet by their names, read anew when light and dark change. */
export function coloursOf(element: Element, names: string[]): Record<string, string> {
  const style = getComputedStyle(element);
  return Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}
