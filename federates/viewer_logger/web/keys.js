// The keyboard: what each key does, and the help that lists them.

import { LAYERS } from "./map.js";
import { element } from "./text.js";

const byId = (id) => document.getElementById(id);

/** Listens to the keys; `page` has the state, the parts and what can be done. */
export function keyboard(page) {
  const { state, map, link, alerts, views, times, finished, setPlaying, toggleRun, command, showTime, showScan, toEvent, setLoop, askTime, insets } = page;
  const { showTimeline, selectNext, select, addressChanged, setColours, setLayer, bookmark } = page;
  const KEYS = [
    ["Space", "freeze or resume; play or pause a finished run", [" "], () => (finished() ? setPlaying(!state.playing) : toggleRun())],
    ["X", "execute one scan (Shift: one frame)", ["x"], (e) => command("step", e.shiftKey)],
    [",  .", "one scan back, forward (Shift: a minute)", [",", "<", ";"], (e) => (e.shiftKey ? showTime((state.scan?.timeS ?? 0) - 60) : times.back())],
    ["", "", [".", ">", ":"], (e) => (e.shiftKey ? showTime((state.scan?.timeS ?? 0) + 60) : times.forth())],
    ["[  ]", "previous, next event", ["["], () => toEvent(-1)], ["", "", ["]"], () => toEvent(1)],
    ["Home End", "to the start, to the newest scan", ["Home"], () => showScan(state.timeline?.first ?? 0)], ["", "", ["End"], times.live],
    ["J", "go to a time", ["j"], askTime], ["A  B", "start and end of a loop", ["a"], () => setLoop(0)], ["", "", ["b"], () => setLoop(1)],
    ["O", "no loop", ["o"], () => {
      state.loop = null;
      showTimeline();
    }],
    ["P", "play from the scan shown", ["p"], times.play], ["L", "back to the newest scan", ["l"], times.live],
    ["D  U", "next, previous target", ["d"], () => selectNext(1)], ["", "", ["u"], () => selectNext(-1)],
    ["Esc", "select nothing", ["Escape"], () => {
      select(null);
      if (map.tools.measuring || map.tools.hits.length) map.tools.clear();
      byId("pointer").dataset.say = "";
    }],
    ["M", "range and bearing between two clicks (Shift: none)", ["m"], (e) => {
      if (e.shiftKey) map.tools.clear();
      else map.tools.measuring = true;
      addressChanged();
    }],
    ["/", "search: call sign, type, number, stand, taxiway", ["/"], () => {
      byId("find").showModal();
      byId("find-text").select();
    }],
    ["K", "acknowledge the first alert", ["k"], () => {
      const first = alerts.first();
      if (first) link.send({ type: "ack", id: first.id });
    }],
    ["I", "a window of its own for the middle of the map (Shift: none)", ["i"], (e) => (e.shiftKey ? insets.closeAll() : views.inset())],
    ["C", "follow the selected target", ["c"], views.follow],
    ["arrows", "move the map", ["ArrowLeft"], () => map.pan(60, 0)], ["", "", ["ArrowRight"], () => map.pan(-60, 0)],
    ["", "", ["ArrowUp"], () => map.pan(0, 60)], ["", "", ["ArrowDown"], () => map.pan(0, -60)],
    ["+  \u2212", "zoom", ["+", "="], views.in], ["", "", ["-"], views.out],
    ["F", "fit the airport", ["f"], views.fit], ["T", "fit the targets", ["t"], views.targets],
    ["1 \u2013 9", "layers on or off, in their order", [], null],
    ["R", "hold and turn the wheel: rotate the map (Shift: runway up)", ["r"], (e) => (e.shiftKey ? map.runwayUp() : (map.turning = true))],
    ["0", "north up", ["0"], () => map.northUp()],
    ["Ctrl 1 \u2013 9", "bookmark of this scene (with Shift: set it)", [], null],
    ["N", "day or night colours", ["n"], () => setColours(document.documentElement.dataset.colours === "night" ? "day" : "night")],
    ["Enter", "to the line for clearances, at a seat or as a controller", [], null],
    ["?", "this help", ["?"], () => byId("help").showModal()],
  ];

  document.addEventListener("keyup", (event) => {
    if (event.key.toLowerCase() === "r") map.turning = false;
  });

  document.addEventListener("keydown", (event) => {
    const digit = /^Digit([1-9])$/.exec(event.code);
    if (event.ctrlKey && !event.altKey && digit) {
      bookmark(digit[1], event.shiftKey);
      event.preventDefault();
      return;
    }
    if (event.ctrlKey || event.altKey || event.metaKey || document.querySelector("dialog[open]")) return;
    const field = event.target.closest?.("input, select, button, tr[tabindex]");
    if (field && (event.target.matches("input[type=range], select") || [" ", "Enter"].includes(event.key))) return;
    const layer = LAYERS[Number(event.key) - 1];
    if (/^[1-9]$/.test(event.key) && layer) setLayer(layer[0], !map.layers[layer[0]]);
    else {
      const key = KEYS.find((k) => k[2].includes(event.key) || k[2].includes(event.key.toLowerCase()));
      if (!key) return;
      key[3](event);
    }
    event.preventDefault();
  });
  makeHelp(KEYS);
}

function makeHelp(KEYS) {
  byId("keys").append(...KEYS.filter((k) => k[0]).map((k) => element("tr", [element("th", k[0], { scope: "row" }), element("td", k[1])])));
  byId("symbols").append(...[
    "Filled circle: track of an aircraft; square: of a vehicle; diamond: not identified; hollow: coasting.",
    "Outline and small cross: truth, to scale once it is large enough; dashed: an outsider's entity.",
    "Small open marks: plots, one mark and colour a sensor as in the list of layers; a plot far from any target is a false one.",
    "Magenta line: error, from track to truth. Ellipse: where the track claims to be with 95 % probability.",
    "Line ahead: where the target will be in 15 s. Dots: where the track was.",
    "Amber arrival, blue departure, green vehicle, grey unknown.",
    "Solid red frame: alarm; broken amber frame: information. Runway outlined: white occupied, blue reserved, red alarm. Stop bars: solid lit, dotted off, crossed: fails. Way of the selected: green where it may drive, broken where it is to go.",
  ].map((text) => element("li", text)));
}
