// The engine's named values in both directions: what the operator's controls read and set.
import { signal, type Signal } from "@preact/signals";
import { Link } from "./link";

export type Value = number | string | boolean;

export interface Widget {
  address: string;
  label: string;
  kind: "fader" | "colour" | "button" | "toggle" | "pad";
  words: string;
  values: Value[];
  once: boolean;
  minimum: number[];
  maximum: number[];
  start: number[];
}

export interface Surface {
  name: string;
  pages: { title: string; widgets: Widget[] }[];
  readings: Record<string, string>;
}

const RATE = 33;

export class Values {
  readonly link: Link;
  readonly refused = signal("");
  /** The invitation by which the operator's team joins with phones; empty: no audience can join. */
  readonly join = signal("");
  /** What can be controlled; null until it is known. */
  readonly surface = signal<Surface | null>(null);
  private readonly kept = new Map<string, Signal<Value[] | null>>();
  private readonly said = new Map<string, { at: number; timer: number }>();

  constructor(key: string) {
    this.link = new Link("/ws", key);
    this.link.onOpen = () => {
      void fetch("/surface.json", { headers: { Authorization: `Bearer ${key}` } })
        .then((answer) => answer.json())
        .then((surface: Surface) => { this.surface.value = surface; });
    };
    this.link.onText = (told) => {
      const values = told["values"] as Record<string, Value[]> | undefined;
      for (const [address, value] of Object.entries(values ?? {})) this.of(address).value = value;
      if (typeof told["refused"] === "string") this.refused.value = told["refused"];
      if (typeof told["join"] === "string") this.join.value = told["join"];
    };
  }

  of(address: string): Signal<Value[] | null> {
    let found = this.kept.get(address);
    if (!found) this.kept.set(address, (found = signal<Value[] | null>(null)));
    return found;
  }

  send(address: string, ...values: Value[]): void {
    this.link.send({ address, values });
  }

  /** Send a value that moves: at most thirty times a second, the last one always. */
  stream(address: string, ...values: Value[]): void {
    const mine = this.said.get(address) ?? { at: 0, timer: 0 };
    this.said.set(address, mine);
    clearTimeout(mine.timer);
    const go = (): void => {
      mine.at = performance.now();
      this.send(address, ...values);
    };
    const rest = mine.at + RATE - performance.now();
    if (rest <= 0) go();
    else mine.timer = window.setTimeout(go, rest);
  }
}
