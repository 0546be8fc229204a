// Starts the page: reads its data, shows a flight, connects all that follows the time cursor.
import { campaign, ending } from "viewer/campaign";
import { drawCharts } from "viewer/charts";
import { Player, connectControls, listenToKeys } from "viewer/player";
import { Stage } from "viewer/stage";
import { unpackFlight } from "viewer/tracks";
import { VIEWS } from "viewer/view";

const content = JSON.parse(document.getElementById("data").textContent);
const page = Object.fromEntries([...document.querySelectorAll("[data-part]")].map((part) => [part.dataset.part, part]));
const asked = new URLSearchParams(location.hash.slice(1));
const player = new Player();
let stage = null;
let newest = 0; // of the flights that were asked for: an older one that unpacks slowly is not shown over it

function makeStage() {
  try {
    return new Stage(page.stage);
  } catch (error) {
    page.message.textContent = `This browser draws no 3-D (${error.message}); tables and plots are complete.`;
    page.message.hidden = false;
    return null;
  }
}

function chooseView(name) {
  if (stage) {
    stage.view.name = name;
    stage.draw();
  }
  markView(name);
}

function markView(name) {
  for (const button of page.views.querySelectorAll("button")) {
    button.setAttribute("aria-pressed", String(button.dataset.view === name));
  }
}

function markPhases(flight) {
  const span = Math.max(flight.end - flight.start, 1e-9);
  page.ticks.replaceChildren(
    ...flight.phases.filter(({ time }) => time > flight.start && time < flight.end).map(({ name, time }) => {
      const tick = document.createElement("span");
      tick.style.left = `${(100 * (time - flight.start)) / span}%`;
      tick.title = `${name}, ${time.toFixed(1)} s`;
      return tick;
    }),
  );
}

function stateAt(flight, time) {
  const until = time < flight.end - 1e-6 ? time + 1e-6 : Infinity; // the end may lie between two moments
  const phase = flight.phases.filter((each) => each.time <= until).at(-1)?.name ?? "";
  const holds = flight.locked?.holds((time - flight.start) / flight.step);
  const pairs = holds ? `${holds} of ${flight.locked.columns} pairs locked` : "";
  return [phase, pairs].filter(Boolean).join(" · ");
}

async function showFlight(number) {
  newest += 1;
  const wanted = newest;
  const flight = await unpackFlight(content.flights[number]);
  if (wanted !== newest) return;
  const geometry = content.systems[flight.system] ?? null;
  const trigger = flight.phases.find(({ name }) => name === "closing")?.time ?? flight.end;
  page.controls.hidden = flight.count === 0;
  page.stage.hidden = page.views.hidden = page.hint.hidden = flight.count === 0 || stage === null;
  if (flight.count && stage) stage.show(flight, geometry);
  for (const part of ["aim", "goal", "thrust", "tether", "locked"]) {
    const there = { aim: flight.aiming, goal: flight.closing.length, thrust: flight.thrust, tether: geometry?.tether && flight.chaser, locked: flight.locked }[part];
    page.key.querySelector(`[data-key="${part}"]`).hidden = !there;
  }
  markPhases(flight);
  page.flight = flight;
  player.span(flight.start, flight.end, Number(asked.get("t") ?? trigger));
  await drawCharts(flight.plots ?? content.plots, flight.phases, player, page.charts);
  page.chartSection.hidden = !page.charts.children.length;
}

function showMission(mission) {
  const [word, kind] = ending(mission);
  page.chosen.className = `verdict ${kind}`;
  page.chosen.replaceChildren();
  page.chosen.append(Object.assign(document.createElement("strong"), { textContent: `Mission ${mission.number}: ${word}` }));
  page.chosen.append(Object.assign(document.createElement("span"), { textContent: mission.error || mission.verdict }));
  page.chosen.hidden = false;
  const flown = mission.flight !== null;
  page.missing.hidden = flown;
  page.flown.hidden = !flown;
  page.command.textContent = mission.command;
  return flown ? showFlight(mission.flight) : undefined;
}

async function start() {
  if (content.flights.length) stage = makeStage();
  connectControls(player, page);
  listenToKeys(player, chooseView);
  page.views.addEventListener("click", (event) => event.target.dataset.view && chooseView(event.target.dataset.view));
  player.follow(() => {
    stage?.at(player.time);
    if (page.flight) page.phase.textContent = stateAt(page.flight, player.time);
  });
  if (content.missions) {
    await campaign(content, page, showMission);
  } else if (content.flights.length) {
    await showFlight(0);
  } else {
    page.flown.hidden = true;
  }
  if (stage) {
    stage.view.controls.addEventListener("start", () => markView("free"));
    chooseView(VIEWS.includes(asked.get("view")) ? asked.get("view") : "beside");
  }
  window.report = { player, stage };
  document.documentElement.dataset.state = "ready";
}

start().catch((error) => {
  page.message.textContent = `The flight cannot be shown: ${error.message}`;
  page.message.hidden = false;
  throw error;
});
