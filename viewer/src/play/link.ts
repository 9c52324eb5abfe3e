// The way to the server: let in once by the token in the address, then a socket, and another one when it is lost.

const FIRST_WAIT_MS = 1000;
const LONGEST_WAIT_MS = 8000;

export interface Linked {
  opened(send: (text: string) => void): void;
  heard(text: string): void;
  /** again: ms until the next try; null where a try makes no sense. */
  lost(why: string, again: number | null): void;
}

const STOPPED = "The server was stopped. The game is kept: `hexwar play --resume` goes on with it, at a new address.";
const ENDED: Record<number, string> = {
  1001: STOPPED,
  1012: STOPPED,
  1008: "The server closed the connection: too many messages in a second.",
  1013: "This game is open in two tabs already. Close one of them, then load this page again.",
};

export class Link {
  private socket: WebSocket | null = null;
  private wait = FIRST_WAIT_MS;
  private timer = 0;
  private wasOpen = false;

  constructor(private readonly page: Linked) {}

  async start(): Promise<void> {
    const token = location.hash.slice(1);
    if (token) {
      history.replaceState(null, "", location.pathname);
      const answer = await fetch("/enter", { method: "POST", body: token }).catch(() => null);
      if (answer && !answer.ok) return this.page.lost("This address lets nobody in any more. Open the one that `hexwar play` printed.", null);
    }
    this.open();
  }

  open(): void {
    window.clearTimeout(this.timer);
    const socket = new WebSocket(`ws://${location.host}/socket`);
    this.socket = socket;
    socket.addEventListener("open", () => {
      this.wasOpen = true;
      this.wait = FIRST_WAIT_MS;
      this.page.opened((text) => socket.send(text));
    });
    socket.addEventListener("message", (event) => this.page.heard(String(event.data)));
    socket.addEventListener("close", (event) => this.closed(socket, event.code));
  }

  private closed(socket: WebSocket, code: number): void {
    if (socket !== this.socket) return;
    if (ENDED[code]) return this.page.lost(ENDED[code], null);
    if (!this.wasOpen) return this.page.lost("The server did not let this page in. Open the address that `hexwar play` printed.", null);
    this.page.lost("The connection was lost, and the clock stands. The game is kept.", this.wait);
    this.timer = window.setTimeout(() => this.open(), this.wait);
    this.wait = Math.min(LONGEST_WAIT_MS, this.wait * 2);
  }
}
