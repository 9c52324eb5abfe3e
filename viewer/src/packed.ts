// A game as a page of many has it (docs/formats/story.md, "Packed"): differences are added up again, views parted.

import type { Changes, OwnDoc, StoryDoc, View } from "./story";

type Doc = Record<string, unknown>;

/** `{field: {view: value}}` as a story of one view, with the parts that games share. */
export function unwoven(woven: Record<string, Partial<Record<View, unknown>>>, view: View, shared: Doc): StoryDoc {
  const own: Doc = { ...shared, view };
  for (const [field, values] of Object.entries(woven)) if (view in values) own[field] = values[view];
  return summed(own as unknown as StoryDoc);
}

/** A story with ticks and cells in place of differences; it is changed. */
export function summed(story: StoryDoc): StoryDoc {
  for (const piece of Object.values(story.pieces ?? {})) {
    for (const name of Object.keys(piece) as (keyof OwnDoc)[]) {
      if (name === "hops") piece.hops = hopsOf(piece.hops);
      else changesOf(piece[name] as Changes<number>, false, name.endsWith("_ends"));
    }
  }
  for (const enemies of Object.values(story.beliefs ?? {})) {
    for (const belief of Object.values(enemies)) for (const [name, list] of Object.entries(belief)) changesOf(list, name === "cell", false);
  }
  let tick = 0;
  for (const event of story.events ?? []) event.tick = tick += event.tick;
  tick = 0;
  for (const order of story.orders ?? []) order[0] = tick += order[0];
  return story;
}

function changesOf(list: Changes<number>, steps: boolean, ends: boolean): void {
  let [tick, last] = [0, 0];
  for (let k = 0; k < list.length; k += 2) {
    list[k] = tick += list[k];
    if (steps) list[k + 1] = last += list[k + 1];
    else if (ends && list[k + 1]) list[k + 1] += tick;
  }
}

function hopsOf(hops: number[][]): number[][] {
  let [end, cell] = [0, 0];
  return hops.map(([wait, ticks, step, broken]) => {
    const start = end + wait;
    end = start + ticks;
    cell += step;
    return broken === undefined ? [start, end, cell] : [start, end, cell, start + broken];
  });
}
