import { createContext, type ComponentChildren } from "preact";
import { useContext } from "preact/hooks";
import { isDrawn, isInside, SHAPES, withPattern, withShape } from "../../model/formations";
import { number, text, type Entry } from "../../model/score";

type Change = (table: Entry) => void;

/** The keys of a formation as fields: those that its shape and pattern have. */
export function FormationFields({ table, onChange }: { table: Entry; onChange: Change }) {
  const shape = text(table, "shape", "grid");
  const set = (key: string, value: unknown): void => onChange({ ...table, [key]: value });
  if (table["like"] !== undefined) return <LikeFields table={table} onChange={onChange} />;
  return (
    <div class="formationfields">
      <Row label="Name"><input aria-label="Name" value={text(table, "name")} maxLength={64} required onInput={(event) => set("name", event.currentTarget.value)} /></Row>
      <Row label="Shape"><Choice value={shape} options={SHAPES} onChange={(value) => onChange(withShape(table, value))} /></Row>
      {(shape === "star" || (shape === "polygon" && !table["points"])) && <Row label={shape === "star" ? "Points" : "Corners"}><Amount table={table} name="corners" usual={5} min={3} max={100} step={1} onChange={onChange} /></Row>}
      {shape === "star" && <Row label="Depth of cuts"><Slider value={1 - number(table, "inner", 0.4)} min={0.05} max={0.95} onChange={(value) => set("inner", round(1 - value))} /></Row>}
      {shape === "spiral" && <Row label="Turns"><Amount table={table} name="turns" usual={2.5} min={0.25} max={20} step={0.25} onChange={onChange} /></Row>}
      {shape === "arc" && <Row label="Angle °"><Amount table={table} name="arc_deg" usual={180} min={1} max={359} step={5} onChange={onChange} /></Row>}
      {shape === "text" && <Row label="Letters"><input aria-label="Letters" value={text(table, "text")} maxLength={40} onInput={(event) => set("text", event.currentTarget.value)} /></Row>}
      {shape === "path" && <Row label="SVG path"><textarea aria-label="SVG path" rows={3} value={Array.isArray(table["path"]) ? (table["path"] as string[]).join(" ") : text(table, "path")} onChange={(event) => set("path", event.currentTarget.value)} /></Row>}
      {shape === "polyline" && <Row label="Ends"><Choice value={String(table["closed"] ?? "")} options={[["", "as drawn"], ["true", "closed"], ["false", "open"]]} onChange={(value) => set("closed", value === "" ? undefined : value === "true")} /></Row>}
      {shape !== "places" && <PatternFields table={table} shape={shape} onChange={onChange} />}
      {shape !== "places" && <NumberField table={table} onChange={onChange} />}
      <SizeFields table={table} onChange={onChange} />
      {shape !== "grid" && shape !== "places" && <SymmetryFields table={table} onChange={onChange} />}
      <OtherFields table={table} shape={shape} onChange={onChange} />
    </div>
  );
}

/** The keys of a formation that is like another one. */
function LikeFields({ table, onChange }: { table: Entry; onChange: Change }) {
  const set = (key: string, value: unknown): void => onChange({ ...table, [key]: value });
  const proportions: [string, string][] = [["", "as neighbours allow"], ["stretch", "fill it"], ["keep", "keep them"]];
  return (
    <div class="formationfields">
      <Row label="Name"><input aria-label="Name" value={text(table, "name")} maxLength={64} required onInput={(event) => set("name", event.currentTarget.value)} /></Row>
      <Row label="Like"><input aria-label="Like" value={text(table, "like")} maxLength={250} required onChange={(event) => set("like", event.currentTarget.value)} /></Row>
      {(["into", "along"] as const).filter((key) => table[key] !== undefined).map((key) => (
        <Row key={key} label={key === "into" ? "Into" : "Along"}>
          {typeof table[key] === "string" ? <input aria-label={key} value={text(table, key)} maxLength={250} onChange={(event) => set(key, event.currentTarget.value || undefined)} /> : <span>{key === "into" ? "a drawn region" : "a drawn line"}</span>}
          <button onClick={() => set(key, undefined)}>Not any more</button>
        </Row>
      ))}
      {(table["into"] !== undefined || table["along"] !== undefined) && <Row label="Proportions"><Choice value={text(table, "proportions")} options={proportions} onChange={(value) => set("proportions", value || undefined)} /></Row>}
      <Row label="Times as large">{Array.isArray(table["scale"]) ? <Pair table={table} name="scale" usual={[1, 1]} min={0.1} onChange={onChange} /> : <Amount table={table} name="scale" usual={1} min={0.1} max={10} step={0.1} onChange={onChange} />}</Row>
      <Row label="Bent °"><Amount table={table} name="bend_deg" usual={0} min={-360} max={360} step={5} onChange={onChange} /></Row>
      <Row label="Turned °"><Amount table={table} name="rotation_deg" usual={0} min={-360} max={360} step={5} onChange={onChange} /></Row>
      <Row label="Moved x, z m"><Pair table={table} name="centre" usual={[0, 0]} min={-100} onChange={onChange} /></Row>
    </div>
  );
}

function PatternFields({ table, shape, onChange }: { table: Entry; shape: string; onChange: Change }) {
  if (shape === "grid") return null;
  const inside = isInside(table);
  const weighted = table["weights"] !== undefined || table["focus"] !== undefined;
  const pattern = text(table, "pattern") || (weighted ? "weighted" : "even");
  const patterns: [string, string][] = inside
    ? [["even", "even"], ["grid", "rows"], ["diagonal", "diagonal"], ["concentric", "as the outline"], ["poisson", "loose"], ["weighted", "denser somewhere"]]
    : [["even", "even"], ["weighted", "denser somewhere"]];
  const weights = (table["weights"] as number[] | undefined) ?? [];
  return (
    <>
      <Row label="Dancers">
        <div class="choice" role="group" aria-label="Dancers">
          <button aria-pressed={!inside} onClick={() => onChange(withPattern(table, "on", "even"))}>on the line</button>
          <button aria-pressed={inside} onClick={() => onChange(withPattern(table, "inside", "even"))}>inside</button>
        </div>
      </Row>
      <Row label="Pattern"><Choice value={pattern} options={patterns} onChange={(value) => onChange(withPattern(table, inside ? "inside" : "on", value))} /></Row>
      {weights.length > 0 && weights.map((weight, index) => (
        <Row key={index} label={`Density ${index + 1}`}>
          <Slider value={weight} min={0} max={10} onChange={(value) => onChange({ ...table, weights: weights.map((one, at) => (at === index ? round(value) : one)) })} />
        </Row>
      ))}
      {table["focus"] !== undefined && (
        <>
          <Row label="Around x, z"><Pair table={table} name="focus" usual={[0, 0]} min={-100} onChange={onChange} /></Row>
          <Row label="Reach m"><Amount table={table} name="focus_reach" usual={2} min={0.1} max={100} step={0.1} onChange={onChange} /></Row>
          <Row label="Strength"><Amount table={table} name="focus_strength" usual={3} min={0} max={100} step={0.5} onChange={onChange} /></Row>
        </>
      )}
    </>
  );
}

function NumberField({ table, onChange }: { table: Entry; onChange: Change }) {
  const kind = ["count", "spacing", "density"].find((key) => table[key] !== undefined) ?? "";
  const usual: Record<string, number> = { count: 12, spacing: 1, density: 0.5 };
  const options: [string, string][] = [["", "as many as dance"], ["count", "fixed number"], ["spacing", "metres between"], ...(isInside(table) ? ([["density", "per m²"]] as [string, string][]) : [])];
  return (
    <Row label="Places">
      <Choice
        value={kind}
        options={options}
        onChange={(value) => {
          const { count: _c, spacing: _s, density: _d, ...rest } = table;
          onChange(value ? { ...rest, [value]: usual[value] } : rest);
        }}
      />
      {kind && <Amount table={table} name={kind} usual={usual[kind] ?? 1} min={kind === "count" ? 1 : 0.1} max={kind === "count" ? 400 : 100} step={kind === "count" ? 1 : 0.1} onChange={onChange} />}
    </Row>
  );
}

function SizeFields({ table, onChange }: { table: Entry; onChange: Change }) {
  return (
    <>
      {!(isDrawn(table) && table["size"] === undefined) && text(table, "shape") !== "places" && (
        <Row label="Width, depth m"><Pair table={table} name="size" usual={[8, 5]} min={0.1} onChange={onChange} /></Row>
      )}
      <Row label="Centre x, z m"><Pair table={table} name="centre" usual={[0, 0]} min={-100} onChange={onChange} /></Row>
      <Row label="Turned °"><Amount table={table} name="rotation_deg" usual={0} min={-360} max={360} step={5} onChange={onChange} /></Row>
    </>
  );
}

function SymmetryFields({ table, onChange }: { table: Entry; onChange: Change }) {
  const mirror = table["mirror"];
  const kind = mirror === undefined ? "" : typeof mirror === "string" ? mirror : typeof mirror === "number" ? "angle" : "line";
  const keeps: [string, string][] = [["", "left or back"], ["left", "left"], ["right", "right"], ["front", "front"], ["back", "back"]];
  return (
    <>
      <Row label="Mirrored">
        <Choice
          value={kind}
          options={[["", "no"], ["left-right", "left to right"], ["front-back", "front to back"], ["angle", "at an angle"], ...(kind === "line" ? ([["line", "at a drawn line"]] as [string, string][]) : [])]}
          onChange={(value) => {
            const { mirror: _m, mirror_at: _a, mirror_keep: _k, ...rest } = table;
            onChange(value ? { ...rest, mirror: value === "angle" ? 45 : value } : rest);
          }}
        />
      </Row>
      {kind === "angle" && <Row label="Line's angle °"><Amount table={table} name="mirror" usual={45} min={-360} max={360} step={5} onChange={onChange} /></Row>}
      {kind && kind !== "line" && <Row label="Through x, z m"><Pair table={table} name="mirror_at" usual={[0, 0]} min={-100} onChange={onChange} /></Row>}
      {kind && <Row label="Side that stays"><Choice value={text(table, "mirror_keep")} options={keeps} onChange={(value) => onChange({ ...table, mirror_keep: value || undefined })} /></Row>}
    </>
  );
}

function OtherFields({ table, shape, onChange }: { table: Entry; shape: string; onChange: Change }) {
  const headings: [string, string][] = [["public", "to the public"], ["centre", "to the middle"], ["outwards", "outwards"], ["along", "along the line"], ["angle", "at an angle"]];
  return (
    <>
      <Row label="They face"><Choice value={text(table, "heading", "public")} options={headings} onChange={(value) => onChange({ ...table, heading: value === "public" ? undefined : value })} /></Row>
      {table["heading"] === "angle" && <Row label="Angle °"><Amount table={table} name="heading_deg" usual={0} min={-360} max={360} step={5} onChange={onChange} /></Row>}
      {shape !== "places" && (
        <Row label="Soloists">
          <Amount table={table} name="soloists" usual={0} min={0} max={100} step={1} onChange={onChange} />
          {number(table, "soloists", 0) > 0 && <Choice value={text(table, "soloist_place", "front")} options={[["front", "in front"], ["centre", "in the middle"]]} onChange={(value) => onChange({ ...table, soloist_place: value === "front" ? undefined : value })} />}
        </Row>
      )}
    </>
  );
}

function round(value: number): number {
  return Math.round(value * 100) / 100;
}

const Label = createContext("");

function Row({ label, children }: { label: string; children: ComponentChildren }) {
  return <Label.Provider value={label}><div class="row"><span>{label}</span><div>{children}</div></div></Label.Provider>;
}

function Choice({ value, options, onChange }: { value: string; options: [string, string][]; onChange: (value: string) => void }) {
  return (
    <select aria-label={useContext(Label)} value={value} onChange={(event) => onChange(event.currentTarget.value)}>
      {options.map(([name, words]) => <option key={name} value={name}>{words}</option>)}
    </select>
  );
}

function Slider({ value, min, max, onChange }: { value: number; min: number; max: number; onChange: (value: number) => void }) {
  return <input type="range" aria-label={useContext(Label)} min={min} max={max} step="0.05" value={value} onInput={(event) => onChange(Number(event.currentTarget.value))} />;
}

function Amount({ table, name, usual, min, max, step, onChange }: { table: Entry; name: string; usual: number; min: number; max: number; step: number; onChange: Change }) {
  return (
    <input
      type="number" aria-label={useContext(Label)} min={min} max={max} step={step} value={number(table, name, usual)}
      onInput={(event) => {
        const value = Number(event.currentTarget.value);
        if (event.currentTarget.value !== "" && value >= min && value <= max && (step !== 1 || Number.isInteger(value))) onChange({ ...table, [name]: value });
      }}
      onChange={(event) => {
        const value = Number(event.currentTarget.value);
        if (!Number.isFinite(value) || event.currentTarget.value === "") event.currentTarget.value = String(number(table, name, usual));
        else onChange({ ...table, [name]: Math.min(max, Math.max(min, step === 1 ? Math.round(value) : value)) });
      }}
    />
  );
}

function Pair({ table, name, usual, min, onChange }: { table: Entry; name: string; usual: [number, number]; min: number; onChange: Change }) {
  const label = useContext(Label);
  const pair = (table[name] as [number, number] | undefined) ?? usual;
  return (
    <>
      {[0, 1].map((index) => (
        <input
          key={index} type="number" step="0.1" min={min} max="200" aria-label={`${label}, ${index ? "second" : "first"} number`} value={pair[index]}
          onInput={(event) => {
            const value = Number(event.currentTarget.value);
            if (event.currentTarget.value === "" || !(value >= min && value <= 200)) return;
            onChange({ ...table, [name]: pair.map((one, at) => (at === index ? value : one)) });
          }}
        />
      ))}
    </>
  );
}
