// Plots against time, with the player's time cursor in each; a click or a drag on a plot moves it.
/* global uPlot */
import { color, unitColor } from "viewer/stage";
import { unpack } from "viewer/tracks";

const HEIGHT = 210;
const FONT = "12px system-ui, sans-serif";

function paint(name) {
  return name.startsWith("unit-") ? unitColor(Number(name.slice(5))) : color(name);
}

function shown(value, unit) {
  if (value === null || value === undefined) return "–";
  const digits = Math.abs(value) >= 100 ? 0 : Math.abs(value) >= 10 ? 1 : 2;
  return `${value.toFixed(digits)}${unit && unit !== "-" ? ` ${unit}` : ""}`;
}

function axis(scale, side, label) {
  return {
    scale, side, label: label === "-" ? undefined : label, labelSize: 18, labelFont: FONT, font: FONT, size: 52, labelGap: 0,
    stroke: () => color("muted"), grid: { show: side === 3, stroke: () => color("rule"), width: 1 },
    ticks: { show: false },
  };
}

function drawMarks(plot, phases) {
  return (u) => {
    const { ctx: brush, bbox: box } = u;
    brush.save();
    brush.beginPath();
    brush.rect(box.left, box.top, box.width, box.height);
    brush.clip();
    brush.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
    brush.textAlign = "left";
    brush.textBaseline = "alphabetic";
    brush.fillStyle = color("muted");
    brush.strokeStyle = color("muted");
    brush.lineWidth = devicePixelRatio;
    for (const { time } of phases) {
      brush.setLineDash([2 * devicePixelRatio, 3 * devicePixelRatio]);
      const x = u.valToPos(time, "x", true);
      brush.beginPath();
      brush.moveTo(x, box.top);
      brush.lineTo(x, box.top + box.height);
      brush.stroke();
    }
    brush.setLineDash([6 * devicePixelRatio, 4 * devicePixelRatio]);
    for (const { value, label } of plot.limits) {
      const y = u.valToPos(value, "y", true);
      brush.beginPath();
      brush.moveTo(box.left, y);
      brush.lineTo(box.left + box.width, y);
      brush.stroke();
      brush.fillText(label, box.left + 6 * devicePixelRatio, y - 4 * devicePixelRatio);
    }
    brush.restore();
  };
}

async function chart(plot, times, phases, player, box) {
  const figure = document.createElement("figure");
  figure.innerHTML = "<figcaption></figcaption><div></div>";
  figure.firstChild.textContent = plot.title;
  box.append(figure);
  const host = figure.lastChild;
  const values = await Promise.all(plot.values.map(unpack));
  const right = plot.lines.some((line) => line.right);
  const range = (u, low, high) => [Math.min(0, low ?? 0), Math.max(Math.min((high ?? 1) * 1.06, plot.top ?? Infinity), ...plot.limits.map((l) => 1.15 * l.value), 1e-3)];
  const options = {
    width: host.clientWidth || 500, height: HEIGHT, padding: [10, right ? 0 : 12, 0, 0],
    scales: {
      x: { time: false, range: [player.begin, player.end] },
      y: { range },
      right: { range: (u, low, high) => [0, Math.max((high ?? 1) * 1.06, 1e-3)] },
    },
    axes: [
      { ...axis("x", 2), size: 28, grid: { show: false }, values: (u, ticks) => ticks.map((tick) => `${tick} s`) },
      axis("y", 3, plot.unit),
      ...(right ? [axis("right", 1, plot.rightUnit)] : []),
    ],
    series: [
      { label: "time", value: (u, v) => (v === null || v === undefined ? "–" : `${v.toFixed(2)} s`) },
      ...plot.lines.map((line) => ({
        label: line.label, scale: line.right ? "right" : "y", stroke: () => paint(line.color), width: 1.5,
        points: { show: false }, dash: line.right ? [5, 3] : undefined,
        paths: line.steps ? uPlot.paths.stepped({ align: 1 }) : undefined,
        value: (u, v) => (line.steps ? `${v ?? "–"}` : shown(v, line.right ? plot.rightUnit : plot.unit)),
      })),
    ],
    cursor: { show: false },
    legend: { show: true, live: true },
    hooks: { draw: [drawMarks(plot, phases)] },
  };
  const u = new uPlot(options, [times, ...values.map((track) => track.column(0))], host);
  u.over.setAttribute("role", "img");
  u.over.setAttribute("aria-label", `${plot.title}; numbers at the time cursor are below`);
  const cursor = u.over.appendChild(Object.assign(document.createElement("div"), { className: "cursor" }));
  const seek = (event) => player.seek(u.posToVal(event.clientX - u.over.getBoundingClientRect().left, "x"));
  u.over.addEventListener("pointerdown", (event) => {
    u.over.setPointerCapture(event.pointerId);
    seek(event);
  });
  u.over.addEventListener("pointermove", (event) => event.buttons && seek(event));
  const step = times.length > 1 ? times[1] - times[0] : 1;
  const follow = () => {
    cursor.style.transform = `translateX(${u.valToPos(player.time, "x")}px)`;
    const index = Math.min(Math.max(Math.round((player.time - times[0]) / step), 0), times.length - 1);
    u.setLegend({ idxs: u.series.map(() => index) }, false);
  };
  new ResizeObserver(() => {
    if (host.clientWidth && Math.abs(host.clientWidth - u.width) > 1) u.setSize({ width: host.clientWidth, height: HEIGHT });
    requestAnimationFrame(follow); // behind uPlot's own update, which empties the legend
  }).observe(host);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    u.redraw(false, true);
    // Marks of the legend have taken their colours when they were made.
    host.querySelectorAll(".u-marker").forEach((mark, i) => i && (mark.style.borderColor = paint(plot.lines[i - 1].color)));
  });
  return follow;
}

/** Draws all plots of a flight into a box, in the place of those before. */
export async function drawCharts(plots, phases, player, box) {
  box.replaceChildren();
  if (!plots) return;
  const times = Array.from({ length: plots.count }, (_, i) => plots.start + i * plots.step);
  const follow = await Promise.all(plots.panels.map((plot) => chart(plot, times, phases, player, box)));
  player.follow(() => follow.forEach((each) => each()));
  follow.forEach((each) => each());
}
