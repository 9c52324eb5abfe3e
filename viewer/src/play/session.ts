// The game as the page knows it: what the server said, put together. No drawing here.

import { type HexMap, parseCell, readMap } from "../hex";
import { type Entry, entriesOf } from "../log";
import { Game } from "../state";
import { type Camp, type Choice, type StoryDoc, withPolicy } from "../story";
import { type HelloDoc, type HintDoc, type NowDoc, type OverDoc, type StateDoc, changed } from "./protocol";

const TOLD = ["events", "orders", "beliefs", "owners"]; // what the log is made of

export class Session {
  readonly camp: Camp;
  readonly map: HexMap;
  role: HelloDoc["role"];
  state: StateDoc;
  story: StoryDoc;
  game: Game;
  entries: Entry[];
  over: OverDoc | null;
  stopped: string | null = null; // why the clock stopped by itself
  refused: NowDoc["refused"] = []; // by the last message
  private readonly tasks: string[] = []; // of the hints
  private readonly hints: [number, Choice[]][] = [];

  constructor(readonly hello: HelloDoc) {
    this.camp = hello.camp;
    this.map = readMap(hello.map);
    this.role = hello.role;
    this.state = hello;
    this.story = hello.story;
    this.over = hello.over;
    this.game = this.read();
    this.entries = entriesOf(this.game);
  }

  get commands(): boolean {
    return this.role === "commands" && !this.over;
  }

  get tick(): number {
    return this.state.clock.tick;
  }

  /** A number that changes where earlier answers are no longer true. */
  get version(): number {
    return this.tick;
  }

  private read(): Game {
    withPolicy(this.story);
    if (this.hints.length) this.story.policy = { [this.camp]: { tasks: this.tasks, decisions: this.hints } };
    return new Game(this.story, this.map);
  }

  take(now: NowDoc): void {
    const { clock, stops, tray, plans, undo, hints } = now;
    this.state = { clock, stops, tray, plans, undo, hints };
    this.refused = now.refused;
    if (clock.running) this.stopped = null;
    if (now.stopped) this.stopped = now.stopped;
    this.story = changed(this.story, now.story);
    this.game = this.read();
    if (TOLD.some((name) => name in now.story)) this.entries = entriesOf(this.game);
  }

  /** A hint is shown as what a policy decided. */
  takeHint(hint: HintDoc): void {
    const piece = this.game.byName(`${this.camp}:${hint.piece}`);
    if (!piece) return;
    const numbers = hint.tasks.map((text) => this.numberOf(text));
    this.hints.push([this.tick, [[piece.index, hint.chosen, numbers, hint.values, ""]]]);
    this.state.hints.used = hint.used;
    this.game = this.read();
  }

  private numberOf(text: string): number {
    if (!this.tasks.includes(text)) this.tasks.push(text);
    return this.tasks.indexOf(text);
  }

  /** Own pieces that nobody has told what to do. */
  isIdle(name: string): boolean {
    const piece = this.game.byName(`${this.camp}:${name}`);
    if (!piece || this.game.shown(piece, this.tick).blood === 0) return false;
    return this.game.doing(piece, this.tick) === "settled" && !this.state.tray[name] && !this.state.plans[name]?.length;
  }

  /** Where that happened for which the clock stopped; -1: nowhere, or it did not. */
  get stoppedAt(): number {
    const text = this.stopped ?? "";
    const cell = parseCell(this.map, /\b([0-9]{4}|[0-9]{6})\b/.exec(text)?.[0] ?? "");
    if (cell >= 0) return cell;
    const piece = this.game.pieces.find((one) => one.camp === this.camp && text.startsWith(`${one.short} `));
    return piece ? this.game.shown(piece, this.tick).cell : -1;
  }

  get waiting(): number {
    return Object.keys(this.state.tray).length;
  }
}
