// The socket: questions get their answers, what the server says by itself goes to the page.

import type { Answers, Ask, Fields, Said } from "./protocol";

const SOFT_A_SECOND = 25; // questions that nobody waits for; the server allows 50 messages

/** The server said no, and why. */
export class Refused extends Error {}

/** What a socket has to do; a WebSocket has it, and so has a test. */
export interface Socket {
  send(text: string): void;
}

export class Wire {
  private next = 1;
  private readonly waiting = new Map<number, { done(answer: never): void; failed(why: Error): void }>();
  private soft: number[] = []; // times of the last questions that nobody waits for

  constructor(
    private readonly socket: Socket,
    private readonly heard: (said: Said) => void,
  ) {}

  ask<A extends Ask>(ask: A, fields: Fields = {}): Promise<Answers[A]> {
    const id = this.next++;
    this.socket.send(JSON.stringify({ id, ask, ...fields }));
    return new Promise((done, failed) => this.waiting.set(id, { done, failed }));
  }

  /** Whether there is room for one more question that nobody waits for. */
  hasRoom(now: number): boolean {
    this.soft = this.soft.filter((time) => now - time < 1000);
    return this.soft.length < SOFT_A_SECOND;
  }

  /** A question that nobody waits for. */
  wonder<A extends Ask>(ask: A, fields: Fields, now: number): Promise<Answers[A]> {
    this.soft.push(now);
    return this.ask(ask, fields);
  }

  take(text: string): void {
    const message = JSON.parse(text);
    const asked = this.waiting.get(message.to);
    this.waiting.delete(message.to);
    if (message.say === "answer") asked?.done(message as never);
    else if (message.say === "refusal") asked?.failed(new Refused(message.why));
    else this.heard(message as Said);
  }

  /** The socket is closed: nobody will answer. */
  close(): void {
    for (const { failed } of this.waiting.values()) failed(new Refused("the connection was lost"));
    this.waiting.clear();
  }
}
