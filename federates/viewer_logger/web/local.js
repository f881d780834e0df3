// What this browser remembers of the page, where it may.

/** Kept in this browser, where it may. */
export function keepLocal(key, value) {
  try {
    localStorage.setItem(key, JSON.stringify(value));
  } catch { /* private window: not kept */ }
}

export function readLocal(key) {
  try {
    return JSON.parse(localStorage.getItem(key));
  } catch {
    return null;
  }
}
