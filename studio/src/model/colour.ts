// Colours: of the engine, linear from 0 to 1, and of the browser, #rrggbb.

export type Colour = [number, number, number];

export function toHex(colour: readonly number[]): string {
  return `#${[0, 1, 2].map((index) => byte(colour[index] ?? 0).toString(16).padStart(2, "0")).join("")}`;
}

export function fromHex(hex: string): Colour {
  const channel = (at: number): number => Math.round((parseInt(hex.slice(at, at + 2), 16) / 255) ** 2.2 * 1e5) / 1e5;
  return [channel(1), channel(3), channel(5)];
}

function byte(linear: number): number {
  return Math.round(255 * Math.min(1, Math.max(0, linear)) ** (1 / 2.2));
}

/** Colours that lighting desks and stages use most: the swatches of colour fields. */
export const SWATCHES: [string, string][] = [
  ["#ffffff", "white"], ["#ffd9a0", "warm white"], ["#bcd8ff", "cold white"], ["#ff4b2e", "red"], ["#ff8a1f", "amber"], ["#ffd23f", "yellow"],
  ["#43c463", "green"], ["#21c7c1", "cyan"], ["#2f7bff", "blue"], ["#7a4dff", "violet"], ["#e04bd0", "magenta"], ["#ff7fa8", "pink"],
];
