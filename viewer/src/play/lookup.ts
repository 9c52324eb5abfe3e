// Answers of the server that are asked for while somebody looks around: one question at a time, the newest first.

import type { Answers, Ask, Fields } from "./protocol";
import { Refused, type Wire } from "./wire";

const MOST_KEPT = 400;
const AGAIN_MS = 250; // until an answer of an earlier tick is asked for again

export class Lookup<A extends "look" | "path"> {
  private readonly answers = new Map<string, { version: number; value: Answers[A] | Refused }>();
  private busy = false;
  private askedAt = 0;

  constructor(
    private readonly ask: A,
    private readonly news: () => void,
  ) {}

  forget(): void {
    this.answers.clear();
    this.busy = false;
  }

  /** The answer to a question, an old one while a new one is under way; undefined: not known yet. */
  get(wire: Wire | null, key: string, fields: Fields, version: number): Answers[A] | Refused | undefined {
    const known = this.answers.get(key);
    const now = performance.now();
    const due = !known || (known.version !== version && now - this.askedAt > AGAIN_MS);
    if (due && wire && !this.busy && wire.hasRoom(now)) void this.fetch(wire, key, fields, version, now);
    return known?.value;
  }

  /** The answer, waited for. */
  async need(wire: Wire | null, key: string, fields: Fields, version: number): Promise<void> {
    if (wire && this.answers.get(key)?.version !== version) await this.fetch(wire, key, fields, version, performance.now());
  }

  private async fetch(wire: Wire, key: string, fields: Fields, version: number, now: number): Promise<void> {
    this.busy = true;
    this.askedAt = now;
    const value = await wire.wonder(this.ask as Ask, fields, now).catch((why: Refused) => why);
    this.busy = false;
    if (this.answers.size >= MOST_KEPT) this.answers.clear();
    this.answers.set(key, { version, value: value as Answers[A] | Refused });
    this.news();
  }
}
