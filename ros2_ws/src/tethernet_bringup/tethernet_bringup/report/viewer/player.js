// The time cursor: what moves it, and who follows it.

const STEP_S = 0.5;
const LONG_STEP_S = 5;

export class Player {
  #listeners = [];
  #last = 0;

  constructor() {
    this.begin = 0;
    this.end = 0;
    this.time = 0;
    this.speed = 1;
    this.playing = false;
  }

  /** Calls `listener(player)` at every change. */
  follow(listener) {
    this.#listeners.push(listener);
  }

  /** Another flight: its span of time [s]. */
  span(begin, end, time) {
    [this.begin, this.end, this.playing] = [begin, end, false];
    this.fresh = true;
    this.seek(time);
    this.fresh = true;
  }

  seek(time) {
    this.time = Math.min(Math.max(time, this.begin), this.end);
    this.fresh = false;
    this.#tell();
  }

  /** Plays or pauses; from the beginning when it has not been moved yet or is at its end. */
  toggle() {
    if (!this.playing && (this.fresh || this.time >= this.end - 1e-6)) this.time = this.begin;
    this.fresh = false;
    this.playing = !this.playing;
    this.#last = performance.now();
    if (this.playing) requestAnimationFrame((now) => this.#advance(now));
    this.#tell();
  }

  #advance(now) {
    if (!this.playing) return;
    // A tab that slept goes on where it was.
    const passed = Math.min(Math.max(now - this.#last, 0), 250) / 1000;
    this.#last = now;
    this.time = Math.min(this.time + this.speed * passed, this.end);
    this.playing = this.time < this.end;
    this.#tell();
    if (this.playing) requestAnimationFrame((next) => this.#advance(next));
  }

  #tell() {
    for (const listener of this.#listeners) listener(this);
  }
}

const own = "input:not([type=range]), select, textarea, button, summary, a, .wide";

/** Space plays and pauses, arrows step, Home and End go to the ends, digits choose a view. */
export function listenToKeys(player, chooseView) {
  document.addEventListener("keydown", (event) => {
    if (event.altKey || event.ctrlKey || event.metaKey || event.target.closest?.(own)) return;
    const step = event.shiftKey ? LONG_STEP_S : STEP_S;
    const actions = {
      " ": () => player.toggle(),
      ArrowLeft: () => player.seek(player.time - step),
      ArrowRight: () => player.seek(player.time + step),
      Home: () => player.seek(player.begin),
      End: () => player.seek(player.end),
      1: () => chooseView("beside"),
      2: () => chooseView("ahead"),
      3: () => chooseView("chaser"),
    };
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
}

/** Connects buttons, slider and clock of the page. */
export function connectControls(player, page) {
  page.play.addEventListener("click", () => player.toggle());
  page.scrub.addEventListener("input", () => player.seek(Number(page.scrub.value)));
  page.speed.addEventListener("change", () => {
    player.speed = Number(page.speed.value);
  });
  player.follow(() => {
    page.play.setAttribute("aria-pressed", String(player.playing));
    page.play.setAttribute("aria-label", player.playing ? "Pause" : "Play");
    page.scrub.min = player.begin;
    page.scrub.max = player.end;
    page.scrub.value = player.time;
    page.scrub.setAttribute("aria-valuetext", `${player.time.toFixed(1)} s after launch`);
    const share = (player.time - player.begin) / Math.max(player.end - player.begin, 1e-9);
    page.scrub.style.setProperty("--share", `${100 * share}%`);
    page.clock.textContent = `${player.time.toFixed(1)} s`;
  });
}
