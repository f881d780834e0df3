// The view of the page as its address has it: what is read from it, and what is written.

/** `e1.2.3` of an entity: its DIS identifier. */
export function entityName(t) {
  if (t.number !== undefined || !t.id.startsWith("e")) return null;
  const key = BigInt(t.id.slice(1));
  return `e${key >> 32n}.${(key >> 16n) & 0xffffn}.${key & 0xffffn}`;
}

/** What the address asks of the page: `apply` a view that was read, and the `state` that is to be written. */
export function viewOf({ state, map, panes, insets, lists, compared, search, openRuns, grantTime, grantSelection }) {
  return {
    apply(wanted) {
      for (const key of ["t", "sel", "follow", "play", "run"]) if (wanted[key] !== undefined) state.wish[key] = wanted[key];
      if (wanted.ab) state.loop = wanted.ab;
      if (wanted.rb) map.tools.setPairs(wanted.rb);
      if (wanted.pane) panes.set(wanted.pane);
      if (wanted.cmp) compared.set(wanted.cmp);
      insets.set([wanted.in1, wanted.in2]);
      if (wanted.find) setTimeout(() => search(wanted.find), 500);
      const before = state.effect;
      state.effect = wanted.eff ? { sensor: Number(wanted.eff[0]), effect: wanted.eff[1] } : null;
      if (wanted.tab) lists.showTab(wanted.tab);
      if (before || state.effect) lists.scan();
      if (wanted.run && state.runs.length) openRuns(wanted.run);
      if (wanted.fit === "targets") setTimeout(() => map.fitTargets(), 600);
      grantTime();
      grantSelection();
    },
    state() {
      const shown = {}, target = map.find(state.selected);
      if (state.shownRuns.length > 1 || (state.runs.length > 1 && state.shownRuns[0] !== state.runs[0]?.id)) shown.run = state.shownRuns;
      if (!state.live && state.scan) shown.t = Number(state.scan.timeS.toFixed(3));
      if (map.tools.lines.length) shown.rb = map.tools.pairs();
      if (state.find) shown.find = state.find;
      Object.assign(shown, insets.state);
      if (panes.list.length) shown.pane = ["map", ...panes.names];
      if (state.loop) shown.ab = state.loop.map((s) => Number(s.toFixed(3)));
      if (target) shown.sel = target.callsign || (target.number !== undefined ? `#${target.number}` : entityName(target));
      if (state.effect) shown.eff = [String(state.effect.sensor), state.effect.effect];
      if (compared.mode) shown.cmp = compared.mode;
      if (state.playing) shown.play = true;
      if (state.tab !== "tracks") shown.tab = state.tab;
      if (map.skin === "controller") shown.skin = "controller";
      if (document.documentElement.dataset.colours === "day") shown.col = "day";
      return shown;
    },
  };
}
