// Numbers of the units: discs that keep their size on the screen and stand beside what they name.
import { CanvasTexture, Sprite, SpriteMaterial, SRGBColorSpace, Vector3 } from "three";

const SIDE = 64;
const SIZE_PX = 19;
const AWAY_PX = 20;

function picture(text, color) {
  const canvas = Object.assign(document.createElement("canvas"), { width: SIDE, height: SIDE });
  const brush = canvas.getContext("2d");
  brush.fillStyle = color;
  brush.beginPath();
  brush.arc(SIDE / 2, SIDE / 2, SIDE / 2 - 3, 0, 2 * Math.PI);
  brush.fill();
  brush.fillStyle = "#fff";
  brush.font = `700 ${text.length > 1 ? 30 : 36}px system-ui, sans-serif`;
  brush.textAlign = "center";
  brush.textBaseline = "middle";
  brush.fillText(text, SIDE / 2, SIDE / 2 + 2);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  return texture;
}

export class Label extends Sprite {
  constructor(number, color, count) {
    super(new SpriteMaterial({ map: picture(String(number), color), depthTest: false, fog: false }));
    const angle = (2 * Math.PI * (number - 1)) / count;
    this.fallback = [Math.cos(angle), Math.sin(angle)];
    this.renderOrder = 10;
  }

  /** Stands beside `place`, away from `middle`; `pixel` is the width of a pixel there [m]. */
  stand(place, middle, camera, pixel) {
    const right = new Vector3().setFromMatrixColumn(camera.matrixWorld, 0);
    const up = new Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
    const away = place.clone().sub(middle);
    let [x, y] = [away.dot(right), away.dot(up)];
    const length = Math.hypot(x, y);
    // Units that have met lie on one another: their labels fan out.
    const share = Math.min(length / (60 * pixel), 1);
    x = share * (x / Math.max(length, 1e-9)) + (1 - share) * this.fallback[0];
    y = share * (y / Math.max(length, 1e-9)) + (1 - share) * this.fallback[1];
    const norm = Math.max(Math.hypot(x, y), 1e-9);
    const far = (AWAY_PX + 10 * (1 - share)) * pixel;
    this.position.copy(place).addScaledVector(right, (far * x) / norm).addScaledVector(up, (far * y) / norm);
    this.scale.setScalar(SIZE_PX * pixel);
  }
}
