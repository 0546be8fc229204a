// Cameras: where from, and how much is in the picture. A preset follows the flight; who takes hold of the scene goes
// along from where it was put.
import { OrbitControls, PerspectiveCamera, Vector3 } from "three";

const FIELD_DEG = 40;
const MARGIN = 1.06; // room for the numbers beside the units
const SAMPLES = 300;
const CALM_S = 1.5; // the picture's frame moves no faster than the mean over so long to both sides
const PRESETS = {
  beside: new Vector3(0.9, 0.36, -0.22).normalize(),
  ahead: new Vector3(0.32, 0.3, -1).normalize(),
};

export const VIEWS = ["beside", "ahead", "chaser"];

/** Centre and radius of what is to be seen, over time. */
export class Framing {
  constructor(flight, debrisRadius) {
    this.start = flight.start;
    this.step = Math.max((flight.end - flight.start) / SAMPLES, flight.step);
    const count = Math.floor((flight.end - flight.start) / this.step + 1e-6) + 1;
    const raw = Array.from({ length: count }, (_, i) => sphereOf(flight, (i * this.step) / flight.step, debrisRadius));
    for (let i = 1; i < count; i += 1) raw[i] ??= raw[i - 1];
    for (let i = count - 2; i >= 0; i -= 1) raw[i] ??= raw[i + 1];
    const known = raw.map((sphere) => sphere ?? [0, 0, 0, 10]);
    const reach = Math.round(CALM_S / this.step);
    this.spheres = known.map((sphere, i) => {
      const near = Math.min(reach, i, count - 1 - i);
      const [x, y, z, radius] = mean(known.slice(i - near, i + near + 1));
      const off = Math.hypot(x - sphere[0], y - sphere[1], z - sphere[2]);
      return [x, y, z, Math.max(radius, sphere[3] + off)];
    });
  }

  at(time) {
    const moment = Math.min(Math.max((time - this.start) / this.step, 0), this.spheres.length - 1);
    const before = this.spheres[Math.floor(moment)];
    const after = this.spheres[Math.min(Math.floor(moment) + 1, this.spheres.length - 1)];
    const share = moment - Math.floor(moment);
    const [x, y, z, radius] = before.map((value, i) => value + share * (after[i] - value));
    return { center: new Vector3(x, y, z), radius };
  }
}

function mean(rows) {
  return rows[0].map((_, i) => rows.reduce((sum, row) => sum + row[i], 0) / rows.length);
}

/** The ball round net, units and debris at a moment; null where nothing is known. */
function sphereOf(flight, moment, debrisRadius) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  const include = (point, margin) => {
    if (!point.every(Number.isFinite)) return;
    for (let axis = 0; axis < 3; axis += 1) {
      low[axis] = Math.min(low[axis], point[axis] - margin);
      high[axis] = Math.max(high[axis], point[axis] + margin);
    }
  };
  const row = Math.min(Math.round(moment), flight.count - 1);
  for (const track of [flight.units, flight.knots]) {
    if (!track) continue;
    const stride = 3 * Math.max(1, Math.floor(track.columns / 3 / 60));
    for (let i = 0; i < track.columns; i += stride) {
      include([0, 1, 2].map((axis) => track.value(row, i + axis)), 0);
    }
  }
  if (flight.debris) include([0, 1, 2].map((axis) => flight.debris.position.value(row, axis)), debrisRadius);
  else if (flight.debrisPlace) include(flight.debrisPlace, debrisRadius);
  if (!Number.isFinite(low[0])) return null;
  const center = low.map((value, axis) => 0.5 * (value + high[axis]));
  return [...center, Math.max(0.5 * Math.hypot(...high.map((value, axis) => value - low[axis])), 1e-3)];
}

export class View {
  #last = new Vector3();

  constructor(canvas, changed) {
    this.camera = new PerspectiveCamera(FIELD_DEG, 1, 0.1, 1000);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.enableZoom = false;
    canvas.style.touchAction = "pan-y"; // a page on a phone still scrolls
    canvas.addEventListener("focus", () => (this.controls.enableZoom = true));
    canvas.addEventListener("blur", () => (this.controls.enableZoom = false));
    canvas.addEventListener("pointerdown", () => canvas.focus({ preventScroll: true }));
    this.controls.addEventListener("start", () => {
      this.name = "free";
      changed();
    });
    this.controls.addEventListener("change", changed);
    this.name = "beside";
  }

  /** Puts the camera in its place for a moment. */
  place({ center, radius }, chaser, chaserSide, aspect) {
    const { camera, controls } = this;
    camera.aspect = aspect;
    if (this.name === "free") {
      const moved = center.clone().sub(this.#last);
      camera.position.add(moved);
      controls.target.add(moved);
    } else if (this.name === "chaser" && chaser) {
      // Above its roof, as somebody who rides on it.
      camera.position.copy(chaser).add(new Vector3(0, 1.1 * chaserSide, 0));
      controls.target.copy(center);
      const share = radius / Math.max(camera.position.distanceTo(center), 1e-6);
      const angle = (2 * Math.asin(Math.min(share, 0.75)) * 180) / Math.PI;
      camera.fov = Math.min(Math.max(1.05 * angle, 6), 76) / Math.min(aspect, 1);
    } else {
      camera.fov = FIELD_DEG;
      const half = Math.atan(Math.tan((0.5 * FIELD_DEG * Math.PI) / 180) * Math.min(aspect, 1));
      const towards = PRESETS[this.name] ?? PRESETS.ahead.clone().setZ(1);
      camera.position.copy(center).addScaledVector(towards, (MARGIN * radius) / Math.sin(half));
      controls.target.copy(center);
    }
    this.#last.copy(center);
    const distance = camera.position.distanceTo(controls.target);
    camera.near = distance / 200;
    camera.far = distance * 30 + 10 * radius;
    camera.updateProjectionMatrix();
    camera.lookAt(controls.target);
    return distance;
  }
}
