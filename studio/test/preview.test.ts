import assert from "node:assert/strict";
import { test } from "node:test";
import { ShowDocument } from "../src/model/document";
import { Preview } from "../src/net/preview";

class FakeSocket {
  static readonly OPEN = 1;
  static last: FakeSocket;
  readyState = 0;
  binaryType = "";
  sent: Record<string, unknown>[] = [];
  onopen = (): void => {};
  onmessage = (_: { data: unknown }): void => {};
  onclose = (): void => {};
  constructor() {
    FakeSocket.last = this;
  }
  open(): void {
    this.readyState = 1;
    this.onopen();
  }
  send(text: string): void {
    this.sent.push(JSON.parse(text));
  }
  close(): void {}
  lose(): void {
    this.readyState = 3;
    this.onclose();
  }
  tell(told: object): void {
    this.onmessage({ data: JSON.stringify(told) });
  }
}

const timers: (() => void)[] = [];
Object.assign(globalThis, {
  WebSocket: FakeSocket, location: { protocol: "http:", host: "x" },
  window: { setTimeout: (what: () => void) => timers.push(what) }, // never by themselves
});

test("questions of other topics wait, an urgent one interrupts and the interrupted one is asked again", async () => {
  const preview = new Preview("key");
  const slow = preview.ask({ from: 57, to: 60 }, "moment");
  const socket = FakeSocket.last;
  socket.open();
  const later = preview.ask({ segment: 3 }, "segment");
  assert.deepEqual(socket.sent.map((one) => one["id"]), [1]);
  const first = preview.ask({ from: 8, to: 8 }, "drag", true);
  assert.equal(socket.sent.length, 2);
  const second = preview.ask({ from: 9, to: 9 }, "drag", true);
  const third = preview.ask({ from: 10, to: 10 }, "drag", true);
  assert.equal((await second).replaced, true); // it waited, and a newer one came
  socket.tell({ kind: "replaced", id: 1 }); // of the interrupted one
  socket.tell({ kind: "done", id: socket.sent[1]?.["id"] });
  assert.equal((await first).replaced, false);
  assert.equal(socket.sent[2]?.["from"], 10);
  socket.tell({ kind: "ways", id: socket.sent[2]?.["id"], ways: [] });
  socket.tell({ kind: "done", id: socket.sent[2]?.["id"] });
  assert.ok((await third).texts["ways"]);
  assert.equal(socket.sent[3]?.["from"], 57); // once more
  socket.tell({ kind: "refused", id: socket.sent[3]?.["id"], refused: [{ what: "no" }] });
  assert.equal((await slow).refused?.[0]?.what, "no");
  assert.equal(socket.sent[4]?.["segment"], 3);
  socket.lose();
  timers.splice(0).forEach((go) => go());
  FakeSocket.last.open();
  assert.equal(FakeSocket.last.sent[0]?.["segment"], 3); // it was lost with the connection
  FakeSocket.last.tell({ kind: "done", id: FakeSocket.last.sent[0]?.["id"] });
  assert.equal((await later).replaced, false);
});

test("an edit that is lost with the connection is sent once again, or it is told that nobody knows", async () => {
  const doc = new ShowDocument("key", "ana");
  doc.link.open();
  FakeSocket.last.open();
  const structure = { kind: "structure", revision: 4, groups: [], library: [], score: {} };
  FakeSocket.last.tell(structure);
  const kept = doc.edit({ do: "set", at: ["seed"], value: 1 });
  const base = FakeSocket.last.sent.at(-1)?.["base"];
  assert.equal(base, 4);
  FakeSocket.last.lose();
  const offline = doc.edit({ do: "set", at: ["seed"], value: 2 });
  timers.splice(0).forEach((go) => FakeSocket.last.readyState === 3 && String(go).includes("open") && go());
  FakeSocket.last.open();
  assert.equal(FakeSocket.last.sent.filter((one) => one["do"] === "set").length, 0); // first the structure
  FakeSocket.last.tell(structure);
  const again = FakeSocket.last.sent.filter((one) => one["do"] === "set");
  assert.deepEqual(again.map((one) => [one["value"], one["base"]]), [[1, 4], [2, 4]]);
  FakeSocket.last.tell({ kind: "answer", id: again[0]?.["id"], revision: 5 });
  let known = false;
  void kept.then(() => { known = true; });
  await Promise.resolve();
  assert.equal(known, false); // the page does not have the change yet
  FakeSocket.last.tell({ kind: "change", revision: 5, what: "edit", by: "ana", of: null, edit: null, shifts: [], entries: [] });
  assert.equal((await kept).revision, 5);
  FakeSocket.last.lose();
  timers.splice(0).forEach((go) => FakeSocket.last.readyState === 3 && String(go).includes("open") && go());
  FakeSocket.last.open();
  FakeSocket.last.tell({ ...structure, revision: 6 });
  assert.match((await offline).refused?.[0]?.what ?? "", /connection was lost/);
  assert.equal(doc.notices.value.length, 1);
});
