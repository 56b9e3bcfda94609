import { effect, signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { stageSize } from "../../model/plan";
import { entries, number, type Group } from "../../model/score";
import type { StageState } from "../../model/stage_state";
import { asLed } from "../../model/danced";
import type { Studio } from "../../model/studio";
import type { Joints, Positions } from "../../net/frames";
import { loadSolid } from "./load_solid";
import { PARENTS, REST_MM } from "./skeleton";
import type { SolidPicture } from "./stage3d";

const JOINTS_A_SECOND = 30;
const TURN_PX = 0.008;
const KEYS: Record<string, [number, number, number]> = {
  ArrowLeft: [-0.12, 0, 1], ArrowRight: [0.12, 0, 1], ArrowUp: [0, 0.1, 1], ArrowDown: [0, -0.1, 1], "+": [0, 0, 0.88], "-": [0, 0, 1.14], "=": [0, 0, 0.88],
};

/** The stage in 3D, from any side: drag, pinch, wheel, or arrows and + -. */
export function SolidStage({ studio, stage }: { studio: Studio; stage: StageState }) {
  const place = useRef<HTMLDivElement>(null);
  const picture = useRef<SolidPicture | null>(null);

  useEffect(() => {
    const element = place.current as HTMLDivElement;
    const stops: (() => void)[] = [];
    let gone = false;
    const refuse = (): void => {
      studio.doc.tell("told", "3D needs WebGL, which this browser does not have here: the stage is shown from above");
      stage.solid.value = false;
    };
    if (!document.createElement("canvas").getContext("webgl2")) {
      refuse();
      return;
    }
    studio.doc.want({ joints: JOINTS_A_SECOND });
    void loadSolid().then(({ SolidPicture }) => {
      if (gone) return;
      try {
        picture.current = new SolidPicture(element, coloursOf(element));
      } catch {
        refuse();
        return;
      }
      stops.push(...connect(studio, stage, element, picture.current));
    });
    return () => {
      gone = true;
      studio.doc.want({ joints: 0 });
      for (const stop of stops) stop();
      picture.current?.dispose();
      picture.current = null;
    };
  }, []);

  const pointers = useRef(new Map<number, [number, number]>());
  return (
    <div class="solid">
      <div
        ref={place}
        class="view"
        role="application"
        tabIndex={0}
        aria-label="The stage in 3D: arrows turn it, plus and minus come nearer and go away"
        onPointerDown={(event) => {
          event.currentTarget.setPointerCapture(event.pointerId);
          pointers.current.set(event.pointerId, [event.clientX, event.clientY]);
        }}
        onPointerMove={(event) => {
          const known = pointers.current;
          const before = known.get(event.pointerId);
          if (!before) return;
          if (known.size === 1) picture.current?.orbit(-(event.clientX - before[0]) * TURN_PX, (event.clientY - before[1]) * TURN_PX);
          else {
            const other = [...known].find(([id]) => id !== event.pointerId)?.[1] ?? before;
            const was = Math.hypot(before[0] - other[0], before[1] - other[1]);
            const is = Math.hypot(event.clientX - other[0], event.clientY - other[1]);
            picture.current?.orbit(0, 0, was / Math.max(is, 1));
          }
          known.set(event.pointerId, [event.clientX, event.clientY]);
        }}
        onPointerUp={(event) => pointers.current.delete(event.pointerId)}
        onPointerCancel={(event) => pointers.current.delete(event.pointerId)}
        onWheel={(event) => {
          event.preventDefault();
          picture.current?.orbit(0, 0, Math.exp(event.deltaY / 600));
        }}
        onKeyDown={(event) => {
          const by = KEYS[event.key];
          if (!by || event.ctrlKey || event.metaKey) return;
          event.preventDefault();
          event.stopPropagation();
          picture.current?.orbit(...by);
        }}
      />
      <div class="choice views" role="group" aria-label="Seen from">
        {[["front", "Front"], ["above", "Above"], ["side", "Side"], ["free", "Aside"]].map(([from, words]) => (
          <button key={from} onClick={() => picture.current?.look(from ?? "front")}>{words}</button>
        ))}
      </div>
    </div>
  );
}

export function coloursOf(element: HTMLElement): { back: string; floor: string; line: string; ink: string; accent: string } {
  const style = getComputedStyle(element);
  const read = (name: string): string => style.getPropertyValue(name).trim();
  return { back: read("--back"), floor: read("--floor"), line: read("--line"), ink: read("--ink"), accent: read("--accent") };
}

/** Keep a picture up to date; returns what ends that. */
function connect(studio: Studio, stage: StageState, element: HTMLElement, picture: SolidPicture): (() => void)[] {
  const looked = signal<Joints | null>(null);
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const recolour = (): void => {
    picture.recolour(coloursOf(element));
    picture.surround(surroundings(studio));
  };
  dark.addEventListener("change", recolour);
  const watch = new ResizeObserver(() => picture.resize(element.clientWidth, element.clientHeight));
  watch.observe(element);
  let groups: unknown = null;
  let painted = "";
  let asked = 0;
  let colours = new Float32Array(0);
  const pose = (positions: Positions, joints: Joints | null, played: Float32Array | null, known: Group[], chosen: number[]): void => {
    const rows = played && played.length >= 66 * positions.count ? played : joints && joints.count >= positions.count ? joints.rows : standing(positions);
    const states = positions.present.join();
    if (known !== groups || states !== painted || colours.length !== rows.length / 22) {
      [groups, painted] = [known, states];
      colours = new Float32Array(rows.length / 22); // a new array: the picture is coloured anew
      for (let dancer = 0; dancer < positions.count; dancer++) colours.set(known[(positions.present[dancer] ?? 1) - 1]?.colour ?? [0.6, 0.6, 0.6], 3 * dancer);
    }
    picture.pose(rows, colours, positions.present, new Set(chosen));
  };
  return [
    effect(() => picture.surround(surroundings(studio))),
    effect(() => {
      // bodies at the cursor
      const measure = stage.looked.value;
      const cursor = studio.cursor.value;
      const tried = stage.without.value ? [] : stage.tried.value;
      void studio.doc.revision.value;
      looked.value = null;
      if (measure === null || cursor === null) return;
      void studio.preview.ask({ measure: measure + (cursor % 1), joints: true, ...asLed(stage.led.value), ...(tried.length ? { with: tried } : {}) }, "joints").then((answer) => {
        if (!answer.replaced) looked.value = answer.joints;
      });
    }),
    effect(() => {
      const positions = stage.shown.value;
      const live = stage.looked.value === null && !stage.played.value;
      const joints = live ? studio.doc.joints.value : stage.played.value ? null : looked.value;
      const played = stage.playedBodies.value;
      const known = studio.doc.structure.value?.groups ?? [];
      const chosen = studio.dancers.value;
      cancelAnimationFrame(asked); // positions and joints come one by one, perhaps several times before a picture is drawn
      asked = requestAnimationFrame(() => { if (positions) pose(positions, joints, played, known, chosen); });
    }),
    () => cancelAnimationFrame(asked),
    () => watch.disconnect(),
    () => dark.removeEventListener("change", recolour),
  ];
}

function surroundings(studio: Studio): Parameters<SolidPicture["surround"]>[0] {
  const score = studio.score.value;
  return {
    ...stageSize(score),
    obstacles: entries(score, "obstacle").map((entry) => ({
      at: (entry["at"] as [number, number] | undefined) ?? [0, 0], to: (entry["wall_to"] as [number, number] | undefined) ?? null, radius: number(entry, "radius", 0.3),
    })),
  };
}

/** Bodies that stand with their arms down, where no joints are known. */
function standing(positions: Positions): Float32Array {
  const size = 3 * PARENTS.length;
  const rows = new Float32Array(positions.count * size);
  for (let dancer = 0; dancer < positions.count; dancer++) {
    const [x, z, heading] = [positions.rows[3 * dancer] ?? 0, positions.rows[3 * dancer + 1] ?? 0, positions.rows[3 * dancer + 2] ?? 0];
    const [sin, cos] = [Math.sin(heading), Math.cos(heading)];
    for (let joint = 0; joint < PARENTS.length; joint++) {
      let [right, up, ahead] = [(REST_MM[3 * joint] ?? 0) / 1000, (REST_MM[3 * joint + 1] ?? 0) / 1000, (REST_MM[3 * joint + 2] ?? 0) / 1000];
      const arm = Math.abs(right) - 0.165;
      if (arm > 0.05) [right, up] = [Math.sign(right) * 0.2, up - arm];
      const to = dancer * size + 3 * joint;
      rows[to] = x + right * cos + ahead * sin;
      rows[to + 1] = up;
      rows[to + 2] = z - right * sin + ahead * cos;
    }
  }
  return rows;
}
