// The scene: net, units with thrust arrows, debris and chaser as their shapes, tether, aiming and closing points.
import {
  BoxGeometry, BufferAttribute, BufferGeometry, Color, ConeGeometry, CylinderGeometry, DirectionalLight, EdgesGeometry,
  Fog, Group, HemisphereLight, Line, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial,
  OctahedronGeometry, Points, PointsMaterial, Scene, SphereGeometry, TorusGeometry, Vector3, WebGLRenderer,
} from "three";
import { Label } from "viewer/labels";
import { Framing, View } from "viewer/view";

const UNIT_PX = 9;
const ARROW_PX = 85; // of a thruster at its limit
const MARK_PX = 15;
const UP = new Vector3(0, 1, 0);

/** The value of a colour in the style sheet. */
export function color(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** The colour of a unit, the same in scene and plots. */
export function unitColor(number) {
  return color(`unit-${((number - 1) % 8) + 1}`);
}

function attribute(count) {
  const values = new BufferAttribute(new Float32Array(3 * count), 3);
  values.usage = 35048; // DYNAMIC_DRAW
  return values;
}

export class Stage {
  #asked = false;

  constructor(box) {
    this.box = box;
    this.renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    const canvas = this.renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute("aria-label", "The flight in three dimensions: drag to turn, scroll to zoom once clicked");
    canvas.setAttribute("role", "img");
    box.prepend(canvas);
    this.view = new View(canvas, () => this.draw());
    this.scene = new Scene();
    new ResizeObserver(() => this.draw()).observe(box);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.flight && this.show(this.flight, this.geometry));
  }

  /** Another flight. */
  show(flight, geometry) {
    Object.assign(this, { flight, geometry });
    this.scene.traverse((part) => {
      part.geometry?.dispose();
      part.material?.dispose();
    });
    this.scene = new Scene();
    this.scene.background = new Color(color("stage"));
    this.scene.fog = new Fog(color("stage"), 1, 100);
    const sun = new DirectionalLight(0xffffff, 1.9);
    sun.position.set(0.7, 1, -0.35);
    this.scene.add(sun, new HemisphereLight(0xffffff, color("shade"), 1.5));
    this.#addNet(flight, geometry);
    this.#addBodies(flight, geometry);
    this.#addUnits(flight, geometry);
    this.#addMarks(flight);
    const radius = this.debrisRadius;
    this.framing = new Framing(flight, radius);
    this.draw();
  }

  #addNet(flight, geometry) {
    const knots = flight.knots ? flight.knots.columns / 3 : 0;
    const units = flight.units ? flight.units.columns / 3 : 0;
    this.knotCount = knots;
    this.points = attribute(knots + units);
    this.row = new Float32Array(3 * knots);
    const lines = (index, name) => {
      const shape = new BufferGeometry();
      shape.setAttribute("position", this.points);
      shape.setIndex(index);
      const segments = new LineSegments(shape, new LineBasicMaterial({ color: color(name) }));
      segments.frustumCulled = false;
      this.scene.add(segments);
      return segments;
    };
    this.net = this.locked = null;
    if (!knots) return;
    const tied = geometry && geometry.nodes === knots;
    if (!tied) {
      const shape = new BufferGeometry();
      shape.setAttribute("position", this.points);
      shape.setDrawRange(0, knots);
      this.net = new Points(shape, new PointsMaterial({ color: color("net"), size: 3, sizeAttenuation: false }));
      this.net.frustumCulled = false;
      this.scene.add(this.net);
      return;
    }
    const hung = geometry.unitNodes.slice(0, units).flatMap((node, unit) => [node, knots + unit]);
    this.net = lines([...geometry.threads, ...hung], "net");
    if (flight.locked && geometry.pairs.length) {
      this.locked = lines(Array(geometry.pairs.length).fill(0), "accent");
      this.lockedRow = new Float32Array(flight.locked.columns);
    }
    if (geometry.tether && flight.chaser) {
      const shape = new BufferGeometry();
      shape.setAttribute("position", attribute(2));
      this.tether = new Line(shape, new LineBasicMaterial({ color: color("tether") }));
      this.tether.frustumCulled = false;
      this.scene.add(this.tether);
    } else this.tether = null;
  }

  #addBodies(flight, geometry) {
    const solid = (shape, name) => {
      const material = new MeshLambertMaterial({
        color: color(name), flatShading: true, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
      });
      const edges = new LineSegments(new EdgesGeometry(shape, 35), new LineBasicMaterial({ color: color(`${name}-edge`) }));
      const body = new Group().add(new Mesh(shape, material), edges);
      this.scene.add(body);
      return body;
    };
    this.debris = this.chaser = this.ghost = null;
    this.debrisRadius = 1;
    const shape = new BufferGeometry();
    if (geometry) {
      shape.setAttribute("position", new BufferAttribute(new Float32Array(geometry.vertices), 3));
      shape.setIndex(geometry.faces);
      shape.computeVertexNormals();
      shape.computeBoundingSphere();
      this.debrisRadius = shape.boundingSphere.radius;
    }
    if (flight.debris && geometry) this.debris = solid(shape, "debris");
    else if (flight.debris || flight.debrisPlace) {
      // Nobody told how it lies: a ball of its size.
      const material = new MeshBasicMaterial({ color: color("muted"), wireframe: true, transparent: true, opacity: 0.35 });
      this.ghost = new Mesh(new SphereGeometry(this.debrisRadius, 20, 12), material);
      if (flight.debrisPlace) this.ghost.position.fromArray(flight.debrisPlace);
      this.scene.add(this.ghost);
    }
    if (flight.chaser) {
      const side = geometry?.chaserSide ?? 1;
      this.chaser = solid(new BoxGeometry(side, side, side), "chaser");
    }
  }

  #addUnits(flight, geometry) {
    const count = flight.units ? flight.units.columns / 3 : 0;
    this.unitRow = new Float32Array(3 * count);
    this.thrustRow = new Float32Array(flight.thrust ? flight.thrust.columns : 0);
    const most = Math.max(...(geometry?.thrustLimits ?? []), 1e-9) * (geometry?.thrustLimits?.length ? 1 : 5e9);
    this.units = Array.from({ length: count }, (_, i) => {
      const paint = unitColor(i + 1);
      const sides = geometry?.unitSides?.[i] ?? [1, 1, 1];
      const longest = Math.max(...sides);
      const body = new Mesh(
        new BoxGeometry(...sides.map((side) => side / longest)),
        new MeshLambertMaterial({ color: paint, flatShading: true }),
      );
      const arrow = arrowOf(paint);
      const label = new Label(i + 1, paint, count);
      this.scene.add(body, arrow, label);
      return { body, arrow, label, size: longest, most: geometry?.thrustLimits?.[i] ?? most };
    });
  }

  #addMarks(flight) {
    const mark = (shape, i) => {
      const made = new Mesh(shape, new MeshBasicMaterial({ color: unitColor(i + 1), fog: false, transparent: true, opacity: 0.9 }));
      this.scene.add(made);
      return made;
    };
    const count = (flight.aiming?.length ?? 0) / 3;
    this.aims = Array.from({ length: count }, (_, i) => {
      const ring = mark(new TorusGeometry(0.5, 0.055, 6, 32), i);
      ring.position.fromArray(flight.aiming, 3 * i);
      return ring;
    });
    const most = Math.max(0, ...flight.closing.map((set) => set.points.length / 3));
    this.goals = Array.from({ length: most }, (_, i) => mark(new OctahedronGeometry(0.42), i));
  }

  /** Shows a moment [s after launch]. */
  at(time) {
    this.time = time;
    this.draw();
  }

  /** Draws with the next frame. */
  draw() {
    if (this.#asked || !this.flight) return;
    this.#asked = true;
    requestAnimationFrame(() => {
      this.#asked = false;
      this.render();
    });
  }

  render() {
    const { flight, renderer, scene, view, box } = this;
    const [width, height] = [box.clientWidth, box.clientHeight];
    if (!width || !height) return;
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer.setSize(width, height, false);
    const time = this.time ?? flight.start;
    const moment = (time - flight.start) / flight.step;
    this.#placeBodies(moment);
    this.#placeNet(moment);
    const sphere = this.framing.at(time);
    const distance = view.place(sphere, this.chaser?.visible ? this.chaser.position : null, this.geometry?.chaserSide ?? 1, width / height);
    view.camera.updateMatrixWorld();
    scene.fog.near = Math.max(distance - 0.4 * sphere.radius, 0.1);
    scene.fog.far = distance + 4.5 * sphere.radius;
    this.pixelAt = (place) =>
      (2 * Math.tan((view.camera.fov * Math.PI) / 360) * view.camera.position.distanceTo(place)) / height;
    this.#placeUnits(moment);
    this.#placeMarks(time);
    renderer.render(scene, view.camera);
  }

  #placeBodies(moment) {
    const place = [0, 0, 0];
    const turn = [0, 0, 0, 1];
    for (const [body, track] of [[this.debris, this.flight.debris], [this.chaser, this.flight.chaser]]) {
      if (!body) continue;
      body.visible = track.position.at(moment, place);
      if (!body.visible) continue;
      body.position.fromArray(place);
      if (track.attitude.at(moment, turn)) body.quaternion.fromArray(turn).normalize();
    }
    if (this.ghost && this.flight.debris && this.flight.debris.position.at(moment, place)) this.ghost.position.fromArray(place);
  }

  #placeNet(moment) {
    const { flight, points, knotCount } = this;
    if (flight.units) flight.units.at(moment, this.unitRow);
    points.array.set(this.unitRow, 3 * knotCount);
    if (this.net) {
      this.net.visible = flight.knots.at(moment, this.row);
      if (this.net.visible) points.array.set(this.row);
    }
    // What is not known lies nowhere: NaN would spoil the whole picture.
    for (let i = 3 * knotCount; i < points.array.length; i += 1) if (Number.isNaN(points.array[i])) points.array[i] = 0;
    points.needsUpdate = true;
    if (this.locked) {
      flight.locked.holdAt(moment, this.lockedRow);
      const index = this.locked.geometry.index;
      this.geometry.pairs.forEach((particle, i) => {
        index.array[i] = this.lockedRow[i >> 1] > 0.5 ? particle : 0;
      });
      index.needsUpdate = true;
      this.locked.visible = this.net.visible;
    }
    if (this.tether) {
      this.tether.visible = this.net.visible && this.chaser.visible;
      const ends = this.tether.geometry.attributes.position;
      new Vector3(0, 0, this.geometry.anchor).applyQuaternion(this.chaser.quaternion).add(this.chaser.position).toArray(ends.array);
      ends.array.set(points.array.slice(3 * this.geometry.center, 3 * this.geometry.center + 3), 3);
      ends.needsUpdate = true;
    }
  }

  #placeUnits(moment) {
    const places = this.units.map((_, i) => new Vector3().fromArray(this.unitRow, 3 * i));
    const known = places.filter((place) => Number.isFinite(place.x));
    const middle = known.reduce((sum, place) => sum.add(place), new Vector3()).divideScalar(Math.max(known.length, 1));
    if (this.flight.thrust) this.flight.thrust.holdAt(moment, this.thrustRow);
    this.units.forEach(({ body, arrow, label, size, most }, i) => {
      const place = places[i];
      body.visible = label.visible = Number.isFinite(place.x);
      arrow.visible = false;
      if (!body.visible) return;
      const pixel = this.pixelAt(place);
      body.position.copy(place);
      body.scale.setScalar(Math.max(size, UNIT_PX * pixel));
      label.stand(place, middle, this.view.camera, pixel);
      const force = new Vector3().fromArray(this.thrustRow, 3 * i);
      const length = (force.length() / most) * ARROW_PX * pixel;
      arrow.visible = length > 4 * pixel;
      if (arrow.visible) arrow.point(place, force, length, pixel);
    });
  }

  #placeMarks(time) {
    const closing = this.flight.phases.find((phase) => phase.name === "closing")?.time ?? Infinity;
    for (const ring of this.aims) {
      ring.visible = time < closing;
      ring.scale.setScalar(MARK_PX * this.pixelAt(ring.position));
      ring.quaternion.copy(this.view.camera.quaternion); // a ring from everywhere
    }
    const points = this.flight.closing.filter((set) => set.time <= time + 1e-6).at(-1)?.points ?? [];
    this.goals.forEach((goal, i) => {
      goal.visible = time >= closing && 3 * i < points.length;
      if (!goal.visible) return;
      goal.position.fromArray(points, 3 * i);
      goal.scale.setScalar(MARK_PX * this.pixelAt(goal.position));
    });
  }
}

function arrowOf(paint) {
  const material = new MeshBasicMaterial({ color: paint, fog: false });
  const shaft = new Mesh(new CylinderGeometry(1, 1, 1, 8).translate(0, 0.5, 0), material);
  const tip = new Mesh(new ConeGeometry(1, 1, 12).translate(0, 0.5, 0), material);
  const arrow = new Group().add(shaft, tip);
  arrow.point = (place, force, length, pixel) => {
    arrow.position.copy(place);
    arrow.quaternion.setFromUnitVectors(UP, force.clone().normalize());
    const head = Math.min(9 * pixel, 0.6 * length);
    shaft.scale.set(1.1 * pixel, length - head, 1.1 * pixel);
    tip.scale.set(3.6 * pixel, head, 3.6 * pixel);
    tip.position.y = length - head;
  };
  return arrow;
}
