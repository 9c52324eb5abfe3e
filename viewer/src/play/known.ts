// What the server has told of places: ways, and what a piece could do there. Asked for when somebody looks.

import { Lookup } from "./lookup";
import type { LookDoc, PathDoc } from "./protocol";
import type { Session } from "./session";
import { Refused, type Wire } from "./wire";

const FOREVER = 0; // version of a way between two cells: the ground does not change

export class Known {
  private readonly paths: Lookup<"path">;
  private readonly legs: Lookup<"path">; // of plans
  private readonly looks: Lookup<"look">;
  private readonly thoughts: Lookup<"look">;

  constructor(
    private readonly wire: () => Wire | null,
    private readonly session: () => Session,
    news: () => void,
  ) {
    this.paths = new Lookup("path", news);
    this.legs = new Lookup("path", news);
    this.looks = new Lookup("look", news);
    this.thoughts = new Lookup("look", news);
  }

  forget(): void {
    for (const lookup of [this.paths, this.legs, this.looks, this.thoughts]) lookup.forget();
  }

  /** The way that a piece would take; from null: from where it is. */
  path(piece: string, from: number | null, to: number): PathDoc | Refused | undefined {
    return this.paths.get(this.wire(), `${piece} ${from} ${to}`, { piece, to, from }, this.session().version);
  }

  /** A leg of a plan. */
  leg(piece: string, from: number | null, to: number): PathDoc | undefined {
    const found = this.legs.get(this.wire(), `${piece} ${from} ${to}`, { piece, to, from }, from === null ? this.session().version : FOREVER);
    return found instanceof Refused ? undefined : found;
  }

  /** What a piece can do now. */
  look(piece: string): LookDoc | undefined {
    const found = this.looks.get(this.wire(), piece, { piece, at: null }, this.session().version);
    return found instanceof Refused ? undefined : found;
  }

  /** What it could do in another cell. */
  thought(piece: string, at: number): LookDoc | undefined {
    const found = this.thoughts.get(this.wire(), `${piece} ${at}`, { piece, at }, this.session().version);
    return found instanceof Refused ? undefined : found;
  }

  /** Wait for what it can do, now or in another cell. */
  need(piece: string, at: number | null): Promise<void> {
    const { version } = this.session();
    if (at === null) return this.looks.need(this.wire(), piece, { piece, at }, version);
    return this.thoughts.need(this.wire(), `${piece} ${at}`, { piece, at }, version);
  }
}
