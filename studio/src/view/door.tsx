import { useState } from "preact/hooks";

/** Asks for the key of the show. */
export function Door({ wrong, onKey }: { wrong: boolean; onKey: (key: string) => Promise<boolean> }) {
  const [tried, setTried] = useState(wrong);
  return (
    <main class="door">
      <form
        onSubmit={async (event) => {
          event.preventDefault();
          const field = (event.currentTarget as HTMLFormElement).elements.namedItem("key") as HTMLInputElement;
          setTried(!(await onKey(field.value)));
        }}
      >
        <h1>Open the studio</h1>
        <label for="key">Paste the link that the show printed when it began, or its key</label>
        <input id="key" name="key" type="password" autocomplete="off" spellcheck={false} required />
        {tried && <p role="alert">This is not the key of the show that runs here.</p>}
        <button class="primary">Open</button>
      </form>
    </main>
  );
}
