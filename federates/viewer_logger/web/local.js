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

let name = null;

/** Who sits at this browser: the same at a seat, at the wheel and on the wire, also where nothing may be kept. */
export function person() {
  name ??= readLocal("person") || `page-${Math.floor(Math.random() * 65536).toString(16).padStart(4, "0")}`;
  return name;
}

/** Another name from now on, kept where it may. */
export function nameAs(other) {
  name = other;
  keepLocal("person", other);
}
