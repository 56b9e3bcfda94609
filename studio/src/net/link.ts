// A WebSocket that comes back by itself, with the key of the show.
import { signal } from "@preact/signals";

const FIRST_WAIT = 400;
const LONGEST_WAIT = 5000;

export type LinkState = "connecting" | "open" | "lost" | "refused";

export class Link {
  readonly state = signal<LinkState>("connecting");
  /** Called after each connection, before the first message. */
  onOpen: () => void = () => {};
  onText: (told: Record<string, unknown>) => void = () => {};
  onBinary: (data: DataView) => void = () => {};
  private socket: WebSocket | null = null;
  private wait = FIRST_WAIT;
  private timer = 0;
  private closed = false;

  constructor(private readonly path: string, private readonly key: string) {}

  open(): void {
    if (this.closed) return;
    const address = `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}${this.path}`;
    const socket = new WebSocket(address, ["live.operator", `live.key.${this.key}`]);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    let opened = false;
    socket.onopen = () => {
      opened = true;
      this.wait = FIRST_WAIT;
      this.state.value = "open";
      this.onOpen();
    };
    socket.onmessage = (event) => {
      if (typeof event.data === "string") this.onText(JSON.parse(event.data));
      else this.onBinary(new DataView(event.data));
    };
    socket.onclose = () => {
      if (this.socket !== socket) return;
      this.socket = null;
      if (opened || this.state.value !== "connecting") this.state.value = "lost";
      this.timer = window.setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(this.wait * 1.6, LONGEST_WAIT);
    };
  }

  /** Send a message; false while there is no connection. */
  send(message: unknown): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  close(): void {
    this.closed = true;
    clearTimeout(this.timer);
    this.socket?.close();
  }
}
