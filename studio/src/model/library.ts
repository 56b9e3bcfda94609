// What the show can be made of, as the engine answers: its steps with their motion, and the places of formations.
import { effect, signal } from "@preact/signals";
import type { Preview, PreviewAnswer, Question } from "../net/preview";
import type { Fault, ShowDocument } from "./document";
import type { Motion } from "./figure";
import type { Places } from "./formations";
import type { Missing, StepFacts } from "./steps";

const MOST_KEPT = 400;

export class Library {
  readonly steps = signal<StepFacts[] | null>(null);
  readonly fault = signal("");
  /** When the clock last came, by this page's time. */
  heard = 0;
  private count = 0;
  private asked = false;
  private names = "";
  private motions = new Map<string, Promise<Motion[]>>();
  private places = new Map<string, Promise<Places>>();
  private waiting: { wish: { formation: unknown; dancers: number }; resolve: (places: Places) => void }[] = [];

  constructor(private readonly preview: Preview, doc: ShowDocument) {
    effect(() => {
      void doc.clock.value;
      this.heard = performance.now();
    });
    effect(() => {
      // steps were added, changed or removed
      const names = JSON.stringify(doc.structure.value?.library ?? []);
      if (names === this.names) return;
      this.names = names;
      this.motions.clear();
      if (this.asked) void this.loadSteps();
    });
    effect(() => {
      void doc.structure.value?.score;
      this.places.clear(); // a name may mean another formation, on another stage
    });
  }

  /** Ask for the steps, once. */
  need(): void {
    if (this.asked) return;
    this.asked = true;
    void this.loadSteps();
  }

  private async loadSteps(): Promise<void> {
    const answer = await this.ask({ steps: true });
    const found = answer.texts["steps"]?.["steps"] as StepFacts[] | undefined;
    if (found) this.steps.value = found;
    this.fault.value = faultOf(answer);
  }

  step(name: string): StepFacts | undefined {
    return this.steps.value?.find((one) => one.name.toLowerCase() === name.toLowerCase());
  }

  /** The motion of takes of a step, by number from 1. */
  motion(step: string, takes: number[] = [1]): Promise<Motion[]> {
    return kept(this.motions, `${step} ${takes.join()}`, async () => {
      const answer = await this.ask({ step, takes });
      const told = answer.texts["motion"];
      const rows = (told?.["takes"] as { measures: number; samples_per_beat: number; contact: number[] }[] | undefined) ?? [];
      return answer.motions.map((samples, index) => ({
        samples, samplesPerBeat: rows[index]?.samples_per_beat ?? 8, contact: rows[index]?.contact ?? [], beats: Number(told?.["beats"] ?? 4) * (rows[index]?.measures ?? 1),
      }));
    });
  }

  /** The places of a formation, by name, in words or as a table. Those that are asked for at once are one question. */
  placesOf(formation: unknown, dancers: number): Promise<Places> {
    return kept(this.places, JSON.stringify([formation, dancers]), () => new Promise((resolve) => {
      this.waiting.push({ wish: { formation, dancers }, resolve });
      if (this.waiting.length === 1) setTimeout(() => void this.askPlaces(), 0);
    }));
  }

  private async askPlaces(): Promise<void> {
    while (this.waiting.length) {
      const some = this.waiting.splice(0, 32);
      const answer = await this.ask({ places: some.map((one) => one.wish) });
      const rows = (answer.texts["places"]?.["places"] as Places[] | undefined) ?? [];
      some.forEach((one, index) => one.resolve(rows[index] ?? ({ ...NO_PLACES, refused: answer.refused ?? [] } as Places)));
    }
  }

  /** What a sequence lacks; null if it can be danced. */
  async missing(steps: string[]): Promise<{ missing: Missing[]; fault: string }> {
    const answer = await this.ask({ sequence: steps.join(", ") });
    return { missing: (answer.texts["sequence"]?.["missing"] as Missing[] | undefined) ?? [], fault: faultOf(answer) };
  }

  /** Ask, after all that was asked before. */
  ask(question: Question): Promise<PreviewAnswer> {
    return this.preview.ask(question, `library ${++this.count}`);
  }
}

export const NO_PLACES: Places = {
  slots: [], heading: [], soloists: 0, lines: [], least_m: null, fits: true, outside: [], scale: 1, move: [0, 0], remedy: "", warnings: [], waiting: 0, empty: 0,
};

function faultOf(answer: PreviewAnswer): string {
  return (answer.refused ?? []).map((fault: Fault) => `${fault.what}${fault.remedy ? ` – ${fault.remedy}` : ""}`).join("; ");
}

function kept<T>(cache: Map<string, Promise<T>>, key: string, make: () => Promise<T>): Promise<T> {
  let found = cache.get(key);
  if (!found) {
    cache.set(key, (found = make()));
    const oldest = cache.keys().next().value;
    if (cache.size > MOST_KEPT && oldest !== undefined) cache.delete(oldest);
  }
  return found;
}
