import { useSignal } from "@preact/signals";
import type { Studio } from "../../model/studio";

/** So long [ms] the button says that it has copied. */
const TOLD_MS = 2000;

/** How phones join: the team by an invitation that stays valid, everyone else by the code on the projectors. */
export function JoinLink({ studio }: { studio: Studio }) {
  const { values } = studio;
  const copied = useSignal(false);
  const link = values.join.value;
  const phones = Number(values.of("/dance/status/phones").value?.[0] ?? 0);
  if (!link) return <p class="join">No audience can join: start the show with <code>--audience</code>.</p>;
  const copy = async (): Promise<void> => {
    await navigator.clipboard?.writeText(link);
    copied.value = true;
    setTimeout(() => { copied.value = false; }, TOLD_MS);
  };
  return (
    <section class="join" aria-label="How phones join">
      <h2>Invitation</h2>
      <p>For you and your team, valid as long as this show runs. Everyone else scans the code on the projectors (Q), which changes.</p>
      <div class="tools">
        <a href={/^https?:/.test(link) ? link : undefined} target="_blank" rel="noreferrer">{link}</a>
        {navigator.clipboard && <button onClick={() => void copy()}>{copied.value ? "Copied" : "Copy"}</button>}
        <button onClick={() => values.send("/dance/audience/invite")} title="With the one before nobody comes in any more; who is in stays">New invitation</button>
      </div>
      <p role="status">{phones === 1 ? "One phone plays" : `${phones} phones play`}</p>
    </section>
  );
}
