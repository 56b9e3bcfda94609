import { useSignal } from "@preact/signals";
import { linkedAlso, type OptionFigures } from "../../model/gap";
import type { Studio } from "../../model/studio";
import { WayPicture } from "./way_picture";

const GRAB_M = 0.6;

/** Who goes where, one by one: press a dancer, then a place; two exchange. Or by number, in the list. */
export function LinkByHand({ studio, dancers, figures, onCancel, onSave }: { studio: Studio; dancers: number[]; figures: OptionFigures; onCancel: () => void; onSave: (points: [number, number][]) => void }) {
  const places = figures.ways.map((way) => way.at(-1) ?? ([0, 0] as [number, number]));
  const of = useSignal(dancers.map((_, row) => row));
  const held = useSignal<number | null>(null);
  const link = (dancer: number, place: number): void => {
    of.value = linkedAlso(of.value, dancer, place);
    held.value = null;
  };
  return (
    <div class="linking">
      <WayPicture
        studio={studio} dancers={dancers} figures={figures} linked={{ places, of: of.value, held: held.value }}
        label="Dancers and their places; the list beside it does the same"
        onPress={(x, z) => {
          const near = (points: [number, number][]): number => nearest(points, x, z);
          if (held.value === null) {
            const dancer = near(figures.ways.map((way) => way[0] ?? [0, 0]));
            held.value = dancer >= 0 ? dancer : null;
          } else {
            const place = near(places);
            if (place >= 0) link(held.value, place);
            else held.value = null;
          }
        }}
      />
      <div class="links">
        <p class="hint">{held.value === null ? "Press a dancer." : `Dancer ${dancers[held.value]}: press the place.`}</p>
        <ol aria-label="Places of the dancers">
          {dancers.map((dancer, row) => (
            <li key={dancer}>
              <label class="field">
                {dancer}
                <select value={String(of.value[row])} aria-label={`Place of dancer ${dancer}`} onChange={(event) => link(row, Number(event.currentTarget.value))}>
                  {places.map(([x, z], place) => <option key={place} value={String(place)}>place {place + 1}: {x.toFixed(1)}, {z.toFixed(1)} m</option>)}
                </select>
              </label>
            </li>
          ))}
        </ol>
        <div class="actions">
          <button onClick={onCancel}>Back</button>
          <button class="primary" onClick={() => onSave(of.value.map((place) => rounded(places[place] ?? [0, 0])))}>Save these links</button>
        </div>
        <p class="hint">They become a formation of their own, whose places have these dancers.</p>
      </div>
    </div>
  );
}

function nearest(points: [number, number][], x: number, z: number): number {
  let [found, distance] = [-1, GRAB_M];
  points.forEach((point, index) => {
    const away = Math.hypot(point[0] - x, point[1] - z);
    if (away < distance) [found, distance] = [index, away];
  });
  return found;
}

function rounded([x, z]: [number, number]): [number, number] {
  return [Math.round(x * 1000) / 1000, Math.round(z * 1000) / 1000];
}
