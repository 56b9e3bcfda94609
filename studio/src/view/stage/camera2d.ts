// From metres on the stage to pixels: seen from above, the public below.

export interface Camera2D {
  width: number;
  height: number;
  /** Pixels of a metre. */
  scale: number;
}

export const MARGIN_M = 1.1;

export function fit(width: number, height: number, stage: { width: number; depth: number }): Camera2D {
  const scale = Math.min(width / (stage.width + 2 * MARGIN_M), height / (stage.depth + 2 * MARGIN_M));
  return { width, height, scale: Math.max(scale, 1) };
}

export function toPixels(camera: Camera2D, x: number, z: number): [number, number] {
  return [camera.width / 2 + x * camera.scale, camera.height / 2 + z * camera.scale];
}

export function toMetres(camera: Camera2D, px: number, py: number): [number, number] {
  return [(px - camera.width / 2) / camera.scale, (py - camera.height / 2) / camera.scale];
}

export function rounded(value: number, digits = 2): number {
  const factor = 10 ** digits;
  return Math.round(value * factor) / factor;
}
