import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { Link } from "../../net/link";
import type { Fault } from "../../model/document";
import "./start_page.css";

export interface StartFacts {
  folder: string;
  name: string;
  songs: string[];
  shows: string[];
  examples: string[];
  most_dancers: number;
}

type Way = "song" | "example" | "open";

const EXAMPLES: Record<string, string> = {
  first_show: "three groups, and music made for them", ballet: "a row of swans that stays together", contemporary: "a storyboard of attractors and bars to cross",
  cues: "a cue list with light, camera and scenes", formations: "formations of every kind", pairs: "partners who lead and follow", samba: "a school of samba",
  score: "sections, canons, calls and signals", tap: "time steps in three",
};
const ASK_AGAIN_MS = 700;

/** Before a show runs: begin one from a song or an example, or open one that is there. */
export function StartPage({ secret, facts, isShow }: { secret: string; facts: StartFacts; isShow: () => Promise<boolean> }) {
  const way = useSignal<Way>(facts.songs.length ? "song" : "example");
  const name = useSignal(facts.name || "my show");
  const song = useSignal(facts.songs[0] ?? "");
  const dancers = useSignal(12);
  const example = useSignal(facts.examples.includes("first_show") ? "first_show" : (facts.examples[0] ?? ""));
  const show = useSignal(facts.shows[0] ?? "");
  const state = useSignal<"choosing" | "making" | "opening">("choosing");
  const faults = useSignal<Fault[]>([]);
  const link = useRef<Link | null>(null);

  useEffect(() => {
    const made = new Link("/studio/start", secret);
    made.onText = (told) => {
      if (told["kind"] === "made") wait();
      else {
        faults.value = told["refused"] as Fault[];
        state.value = "choosing";
      }
    };
    made.open();
    link.current = made;
    let timer = 0;
    const wait = (): void => {
      state.value = "opening";
      made.close();
      timer = window.setInterval(() => void isShow().then((there) => { if (there) location.reload(); }), ASK_AGAIN_MS);
    };
    return () => {
      made.close();
      clearInterval(timer);
    };
  }, [secret]);

  const choose = (event: Event): void => {
    event.preventDefault();
    faults.value = [];
    const wish = way.value === "open"
      ? { open: show.value }
      : { name: name.value.trim(), ...(way.value === "song" ? { song: song.value, dancers: dancers.value } : { example: example.value }) };
    if (link.current?.send(wish)) state.value = "making";
    else faults.value = [{ what: "No connection: try again in a moment" }];
  };
  const ways: [Way, string, boolean][] = [["song", "From a song", true], ["example", "From an example", true], ["open", "Open a show", facts.shows.length > 0]];
  const busy = state.value !== "choosing";
  return (
    <main class="start">
      <form onSubmit={choose}>
        <h1>{way.value === "open" ? "Open a show" : "A new show"}</h1>
        <div class="choice" role="group" aria-label="How it begins">
          {ways.filter(([, , there]) => there).map(([one, words]) => (
            <button key={one} type="button" aria-pressed={way.value === one} disabled={busy} onClick={() => { way.value = one; }}>{words}</button>
          ))}
        </div>
        {way.value !== "open" && (
          <label>Name
            <input value={name.value} maxLength={60} required disabled={busy} onInput={(event) => { name.value = event.currentTarget.value; }} />
            <small>It becomes a folder in {facts.folder}.</small>
          </label>
        )}
        {way.value === "song" && (facts.songs.length > 0 ? (
          <>
            <label>Song
              <select value={song.value} disabled={busy} onChange={(event) => { song.value = event.currentTarget.value; }}>
                {facts.songs.map((one) => <option key={one} value={one}>{one}</option>)}
              </select>
              <small>Its measures are found by listening. They can be corrected later.</small>
            </label>
            <label>Dancers
              <input type="number" min="1" max={facts.most_dancers} value={dancers.value} required disabled={busy} onInput={(event) => { dancers.value = Math.round(Number(event.currentTarget.value)); }} />
            </label>
          </>
        ) : <p class="hint">There is no music in {facts.folder}. Put a song there (ogg, wav, flac, mp3, m4a) and reload this page.</p>)}
        {way.value === "example" && (
          <fieldset disabled={busy}>
            <legend>Example</legend>
            {facts.examples.map((one) => (
              <label key={one} class="pick">
                <input type="radio" name="example" checked={example.value === one} onChange={() => { example.value = one; }} />
                <b>{one.replaceAll("_", " ")}</b> <small>{EXAMPLES[one] ?? ""}</small>
              </label>
            ))}
          </fieldset>
        )}
        {way.value === "open" && (
          <label>Show
            <select value={show.value} disabled={busy} onChange={(event) => { show.value = event.currentTarget.value; }}>
              {facts.shows.map((one) => <option key={one} value={one}>{one}</option>)}
            </select>
            <small>Those in {facts.folder}</small>
          </label>
        )}
        {faults.value.map((fault, index) => <p key={index} role="alert">{fault.what}{fault.remedy ? ` – ${fault.remedy}` : ""}</p>)}
        <button class="primary" disabled={busy || (way.value === "song" && !song.value)}>{way.value === "open" ? "Open" : "Begin"}</button>
        <p class="hint" role="status">{STATES[state.value] ?? ""}</p>
      </form>
    </main>
  );
}

const STATES: Record<string, string> = {
  making: "The music is heard and the show is written …", opening: "The show begins. The first time this takes a minute …",
};
