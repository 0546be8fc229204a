// The missions of a campaign: maps and a list; a click on one shows its flight, or says how to get it.

const SHOWN_AT_ONCE = 100;
const MAP = 320;
const [LEFT, BOTTOM, REST] = [56, 42, 12]; // margins of a map
const SVG = "http://www.w3.org/2000/svg";

const FILTERS = {
  "all missions": () => true,
  "with a flight": (mission) => mission.flight !== null,
  "not captured": (mission) => !mission.captured,
  "captured, not held": (mission) => mission.captured && mission.held === false,
  "in error": (mission) => Boolean(mission.error),
};

/** How a mission ended, as a word and as a class of the style sheet. */
export function ending(mission) {
  if (mission.error) return ["in error", "error"];
  if (!mission.captured) return ["not captured", "bad"];
  if (mission.held === false) return ["captured, not held", "open"];
  return [mission.held ? "captured and held" : "captured", "good"];
}

function svg(name, attributes, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

function nice(low, high) {
  const power = 10 ** Math.floor(Math.log10((high - low) / 4 || 1));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((each) => (high - low) / each <= 5) ?? 10 * power;
  const ticks = [];
  for (let tick = Math.ceil(low / step) * step; tick <= high + 1e-9; tick += step) ticks.push(Number(tick.toPrecision(6)));
  return ticks;
}

function drawMap(map, missions, choose) {
  const picture = svg("svg", { viewBox: `0 0 ${MAP} ${MAP}`, role: "img", "aria-label": map.title });
  const [width, height] = [MAP - LEFT - REST, MAP - BOTTOM - REST];
  const [[x0, x1], [y0, y1]] = [map.xRange, map.yRange];
  const place = (x, y) => [LEFT + ((x - x0) / (x1 - x0 || 1)) * width, REST + height - ((y - y0) / (y1 - y0 || 1)) * height];
  if (map.disc) {
    for (const radius of [1, ...map.circles]) {
      const [x, y] = place(0, 0);
      picture.append(svg("circle", { cx: x, cy: y, r: (radius * width) / (x1 - x0), class: "rule" }));
    }
  } else {
    picture.append(svg("rect", { x: LEFT, y: REST, width, height, class: "rule" }));
    for (const tick of nice(x0, x1)) {
      picture.append(svg("text", { x: place(tick, 0)[0], y: REST + height + 15, class: "tick middle" }, tick));
    }
    for (const tick of nice(y0, y1)) {
      picture.append(svg("text", { x: LEFT - 6, y: place(0, tick)[1] + 4, class: "tick end" }, tick));
    }
  }
  picture.append(svg("text", { x: MAP / 2, y: MAP - 8, class: "label middle" }, map.xLabel));
  picture.append(svg("text", { x: 12, y: MAP / 2, class: "label middle", transform: `rotate(-90 12 ${MAP / 2})` }, map.yLabel));
  const size = missions.length > 400 ? 2.6 : missions.length > 100 ? 3.6 : 5;
  const dots = new Map();
  missions.forEach((mission, i) => {
    if (map.x[i] === null || map.y[i] === null) return;
    const [x, y] = place(map.x[i], map.y[i]);
    const kind = ending(mission)[1];
    const dot = svg("circle", { cx: x, cy: y, r: size, class: `dot ${kind}${mission.flight === null ? "" : " flight"}` });
    dot.append(svg("title", {}, `mission ${mission.number}: ${ending(mission)[0]}`));
    dot.addEventListener("click", () => choose(mission));
    dots.set(mission, dot);
    picture.append(dot);
  });
  const figure = document.createElement("figure");
  const caption = document.createElement("figcaption");
  caption.textContent = map.title;
  figure.append(caption, picture);
  return { figure, dots };
}

function cell(row, text, kind = "td") {
  const made = document.createElement(kind);
  made.textContent = text;
  row.append(made);
  return made;
}

function listOf(missions, choose, table) {
  const head = ["", "ended", "system", "group", "policy", "pairs", "CQI", "fuel per unit", "trigger"];
  table.innerHTML = "<thead><tr></tr></thead><tbody></tbody>";
  head.forEach((text) => cell(table.querySelector("tr"), text, "th"));
  const body = table.querySelector("tbody");
  const rows = new Map();
  let [chosen, count] = [missions, 0];
  const more = () => {
    for (const mission of chosen.slice(count, count + SHOWN_AT_ONCE)) {
      const row = body.insertRow();
      const [word, kind] = ending(mission);
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = mission.number;
      button.title = mission.flight === null ? "how to see its flight" : "show its flight";
      button.addEventListener("click", () => choose(mission));
      cell(row, "", "th").append(button);
      cell(row, word).className = kind;
      const fixed = (value, digits, unit) => (value === null ? "–" : `${value.toFixed(digits)}${unit}`);
      for (const text of [
        mission.system, mission.group, mission.policy, mission.pairs, fixed(mission.cqi, 2, ""),
        fixed(mission.fuel, 2, " g"), fixed(mission.trigger, 1, " s"),
      ]) cell(row, text);
      if (mission.flight !== null) row.classList.add("flight");
      rows.set(mission, row);
    }
    count = Math.min(count + SHOWN_AT_ONCE, chosen.length);
    return chosen.length - count;
  };
  const filter = (test) => {
    body.replaceChildren();
    rows.clear();
    [chosen, count] = [missions.filter(test), 0];
    return more();
  };
  return { more, filter, rows };
}

/** Fills the page's parts for a campaign; `show(mission)` is called with the one that is chosen, first of all one with a flight. */
export function campaign(content, page, show) {
  const { missions } = content;
  const marked = [];
  const choose = (mission) => {
    marked.splice(0).forEach((each) => each.classList.remove("chosen"));
    for (const place of [...maps.map((map) => map.dots.get(mission)), list.rows.get(mission)]) {
      if (!place) continue;
      place.classList.add("chosen");
      marked.push(place);
    }
    return show(mission);
  };
  const maps = content.maps.map((map) => drawMap(map, missions, choose));
  page.maps.append(...maps.map((map) => map.figure));
  const list = listOf(missions, choose, page.list);
  const tell = (left) => {
    page.more.hidden = !left;
    page.more.textContent = `${left} more`;
  };
  for (const [name, test] of Object.entries(FILTERS)) {
    const count = missions.filter(test).length;
    if (count) page.filter.append(new Option(`${name} (${count})`, name));
  }
  page.filter.addEventListener("change", () => tell(list.filter(FILTERS[page.filter.value])));
  page.more.addEventListener("click", () => tell(list.more()));
  tell(list.more());
  page.campaign.hidden = false;
  const first = missions.find((mission) => mission.flight !== null) ?? missions[0];
  return first ? choose(first) : undefined;
}
