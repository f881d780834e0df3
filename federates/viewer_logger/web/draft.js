// The draft of a scene: its text, what it was before, and the places of a route that is being clicked. No DOM here.

/** Steps that can be taken back. */
export const MOST_UNDO = 50;

/** A text with what it was before. */
export function draftOf(text, past = []) {
  return {
    text,
    past,
    /** The next text; the same again is not a step. */
    to(next) {
      return next === text ? this : draftOf(next, [...past, text].slice(-MOST_UNDO));
    },
    back() {
      return past.length ? draftOf(past.at(-1), past.slice(0, -1)) : this;
    },
  };
}

/** The places of a route with one more; the last one again is taken back. */
export function choose(via, name) {
  return via.at(-1) === name ? via.slice(0, -1) : [...via, name];
}

/** The nearest of some things to a pixel, at most so far away; null where none is. */
export function nearestOf(list, [px, py], pixelOf, most) {
  let best = null, nearest = most;
  for (const thing of list) {
    const [x, y] = pixelOf(thing), far = Math.hypot(x - px, y - py);
    if (far <= nearest) [best, nearest] = [thing, far];
  }
  return best;
}
