// A game of the page, in the views that somebody has looked at.

import type { EntryDoc } from "./contents";
import type { HexMap } from "./hex";
import { type Entry, type LuckCurve, entriesOf, luckOf } from "./log";
import { Game } from "./state";
import { type Camp, type StoryDoc, type View, loadClip, loadStory } from "./story";

export class Tape {
  game!: Game; // in the view that is shown
  private readonly games = new Map<View, Game>();
  private readonly entries = new Map<View, Entry[]>();
  private lucky: Partial<Record<Camp, LuckCurve>> | undefined;

  constructor(
    readonly number: number,
    readonly entry: EntryDoc | null, // none on the page of one game
    readonly views: View[],
    private readonly mapOf: (key: string) => Promise<HexMap>,
  ) {}

  get name(): string {
    return this.entry?.name ?? "";
  }

  async show(view: View): Promise<void> {
    let game = this.games.get(view);
    if (!game) {
      const story: StoryDoc = await (this.entry ? loadClip(this.number, this.entry, view) : loadStory(this.number, view));
      game = new Game(story, await this.mapOf(story.map));
      this.games.set(view, game);
      this.entries.set(view, entriesOf(game));
    }
    this.game = game;
  }

  list(): Entry[] {
    return this.entries.get(this.game.view) ?? [];
  }

  /** Luck is told where the dice are known. */
  get luck(): Partial<Record<Camp, LuckCurve>> {
    if (this.game.view !== "referee") return {};
    this.lucky ??= { red: luckOf(this.game, "red"), blue: luckOf(this.game, "blue") };
    return this.lucky;
  }

  curves() {
    return this.game.story.margin ?? this.game.story.known_margin;
  }
}
