// Two games on one clock: where they part.

import { CAMPS, type Camp, type Changes, type OrderDoc, type StoryDoc } from "./story";

export interface Parting {
  tick: number; // the first at which anything is different
  orders: Partial<Record<Camp, number>>; // the first at which a camp orders something else
}

const NEVER = Number.POSITIVE_INFINITY;

/** The first tick at which two games of one seed differ; null where they are the same, or their dice are others. */
export function partingOf(a: StoryDoc, b: StoryDoc): Parting | null {
  if (a.seed === undefined || a.seed !== b.seed) return null;
  const orders: Parting["orders"] = {};
  for (const camp of CAMPS) {
    const tick = firstOther(ordersOf(a, camp), ordersOf(b, camp), (order) => order[0]);
    if (tick < NEVER) orders[camp] = tick;
  }
  const tick = Math.min(...Object.values(orders), ...piecesPart(a, b), firstOther(a.events, b.events, (event) => event.tick));
  return tick < NEVER ? { tick, orders } : null;
}

function ordersOf(story: StoryDoc, camp: Camp): OrderDoc[] {
  return story.orders.filter((order) => order[1] === camp);
}

function piecesPart(a: StoryDoc, b: StoryDoc): number[] {
  return Object.keys(a.pieces).flatMap((name) => {
    const [one, other] = [a.pieces[name], b.pieces[name]];
    if (!other) return [0];
    const hops = firstOther(one.hops, other.hops, (hop) => hop[0]);
    return [hops, changesPart(one.blood, other.blood), changesPart(one.cell ?? [], other.cell ?? [])];
  });
}

/** The first tick at which two lists of changes hold other values. */
export function changesPart(a: Changes<unknown>, b: Changes<unknown>): number {
  const pairs = (list: Changes<unknown>) => list.flatMap((_, k) => (k % 2 ? [] : [[list[k], list[k + 1]] as [number, unknown]]));
  return firstOther(pairs(a), pairs(b), (pair) => pair[0]);
}

function firstOther<T>(a: T[], b: T[], tickOf: (one: T) => number): number {
  const most = Math.max(a.length, b.length);
  for (let k = 0; k < most; k++) {
    if (k < a.length && k < b.length && JSON.stringify(a[k]) === JSON.stringify(b[k])) continue;
    return Math.min(...[a[k], b[k]].filter((one) => one !== undefined).map(tickOf));
  }
  return NEVER;
}
