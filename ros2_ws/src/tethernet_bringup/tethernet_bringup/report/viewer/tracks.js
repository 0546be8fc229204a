// Packed numbers over time (report/packing.py), and what they are between two moments.

const MISSING = 65535;

async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Rows of numbers, one row a moment. */
export class Track {
  constructor(packed, words) {
    this.rows = packed.rows;
    this.columns = packed.columns;
    this.low = packed.low;
    this.step = packed.step;
    this.words = words;
  }

  /** A value; NaN where it is missing. */
  value(row, column) {
    const word = this.words[row * this.columns + column];
    return word === MISSING ? NaN : this.low[column % this.low.length] + word * this.step;
  }

  /** Fills `out` with the row at a moment (a row number with a fraction), straight in between; false where a value is missing. */
  at(moment, out) {
    const { rows, columns, low, step, words } = this;
    const inside = Math.min(Math.max(moment, 0), rows - 1);
    const before = Math.floor(inside) * columns;
    const after = Math.min(Math.floor(inside) + 1, rows - 1) * columns;
    const share = inside - Math.floor(inside);
    let whole = true;
    for (let column = 0, axis = 0; column < columns; column += 1, axis = axis + 1 === low.length ? 0 : axis + 1) {
      const a = words[before + column];
      const b = words[after + column];
      if (a === MISSING || b === MISSING) {
        const known = share < 0.5 ? a : b;
        out[column] = known === MISSING ? NaN : low[axis] + known * step;
        whole = whole && known !== MISSING;
      } else {
        out[column] = low[axis] + (a + (b - a) * share) * step;
      }
    }
    return whole;
  }

  /** Fills `out` with the last row before a moment. */
  holdAt(moment, out) {
    const row = Math.min(Math.max(Math.floor(moment + 1e-6), 0), this.rows - 1);
    for (let column = 0; column < this.columns; column += 1) out[column] = this.value(row, column);
  }

  /** How many numbers of the last row before a moment are 1 rather than 0. */
  holds(moment) {
    const row = Math.min(Math.max(Math.floor(moment + 1e-6), 0), this.rows - 1);
    return Array.from({ length: this.columns }, (_, column) => this.value(row, column)).filter((value) => value > 0.5).length;
  }

  /** One column as uPlot wants it: null where a value is missing. */
  column(number) {
    return Array.from({ length: this.rows }, (_, row) => {
      const value = this.value(row, number);
      return Number.isNaN(value) ? null : value;
    });
  }
}

/** A track from its packed form; null from null. */
export async function unpack(packed) {
  if (!packed) return null;
  const bytes = await inflate(packed.data);
  const count = packed.rows * packed.columns;
  const words = new Uint16Array(count);
  for (let i = 0; i < count; i += 1) {
    const change = bytes[i] | (bytes[count + i] << 8);
    words[i] = (i < packed.columns ? 0 : words[i - packed.columns]) + change; // modulo 2^16
  }
  return new Track(packed, words);
}

/** A flight with its tracks unpacked. */
export async function unpackFlight(flight) {
  const body = async (packed) =>
    packed && { position: await unpack(packed.position), attitude: await unpack(packed.attitude) };
  const [knots, units, thrust, locked] = await Promise.all(
    [flight.knots, flight.units, flight.thrust, flight.locked].map(unpack),
  );
  const [debris, chaser] = await Promise.all([flight.debris, flight.chaser].map(body));
  return { ...flight, knots, units, thrust, locked, debris, chaser, end: flight.start + flight.step * (flight.count - 1) };
}
