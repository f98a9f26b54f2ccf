// The film out of the page: base64, gzip, bytes sorted by significance (packing.py).

const KINDS = { f4: Float32Array, f8: Float64Array, i4: Int32Array, i1: Int8Array, d2: Uint16Array };

async function bytesOf(text) {
  const raw = atob(text), packed = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) packed[k] = raw.charCodeAt(k);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function unpack({ dtype, shape, data, low, step }) {
  const sorted = await bytesOf(data), Kind = KINDS[dtype], size = Kind.BYTES_PER_ELEMENT, n = sorted.length / size;
  const bytes = new Uint8Array(sorted.length);
  for (let b = 0; b < size; b++) for (let k = 0; k < n; k++) bytes[k * size + b] = sorted[b * n + k];
  const values = new Kind(bytes.buffer);
  return dtype === "d2" ? addedUp(values, shape, low, step) : values;
}

// Differences from frame to frame in 16 bits, as positions again.
function addedUp(jumps, shape, low, step) {
  const values = new Float32Array(jumps.length), row = jumps.length / shape[0], d = low.length;
  for (let k = row; k < jumps.length; k++) jumps[k] += jumps[k - row]; // modulo 65536
  for (let k = 0; k < jumps.length; k++) values[k] = low[k % d] + step[k % d] * jumps[k];
  return values;
}

async function readFilm(json) {
  const film = { ...json, n: json.times.shape[0] };
  for (const name of ["times", "position", "turn"]) film[name] = await unpack(json[name]);
  film.contacts = {};
  for (const name in json.contacts) film.contacts[name] = await unpack(json.contacts[name]);
  for (const body of film.bodies) {
    for (const shape of body.shapes) {
      shape.size = shape.points.shape; // (k, d), of a bending line (n_t, k, d)
      shape.points = await unpack(shape.points);
    }
  }
  film.curves = await Promise.all(json.curves.map(async ([group, name, unit, values, scale, colour, dashes]) => ({ group, name, unit, values: await unpack(values), scale, colour, dashes })));
  for (const mode of film.modes) mode.push(mode[3]); // its colour on white: on black it is lighter
  film.marks = json.marks.map(([t, frame, kind, text, choice]) => ({ t, frame, kind, text, choice, isParadox: json.paradox.kinds.includes(kind) }));
  film.modeOf = modeTable(film);
  film.forces = contactForces(film);
  film.usualReach = usualReach(film);
  film.colouring = new Colouring(film);
  film.moving = new Moving(film);
  return film;
}

// How far a shape reaches from the centre of its body.
function reachOf({ points, radius, place, size }, d) {
  const m = size[size.length - 2], away = Array.from({ length: m }, (_, i) => Math.hypot(...points.subarray(d * i, d * i + d)));
  return radius + Math.hypot(...(place ?? []).slice(0, d)) + Math.max(0, ...away);
}

// How far a body of the middle size reaches, of those that move: 0 without one.
function usualReach({ bodies, dimension }) {
  const reach = bodies.filter((body) => !body.fixed).flatMap(({ shapes }) => shapes.filter(({ size }) => size[0] > 0).map((shape) => reachOf(shape, dimension)));
  return reach.length ? quantile(reach, 0.5) : 0;
}

// contact => [mode, sign of sliding, name, colour]
function modeTable({ modes, contacts }) {
  const of = (mode, slip) => modes.find((row) => row[0] === mode && row[1] === slip) ?? modes.find((row) => row[0] === mode);
  const table = [0, 1, 2, 3].map((mode) => [-1, 0, 1].map((slip) => of(mode, slip)));
  return (c) => table[contacts.mode[c]][contacts.slip[c] + 1];
}

// Mean force of each contact since the frame before [N]; at an instant, or of the last step, its impulse [N s]. `typical` sizes the arrows.
function contactForces({ n, times, dimension: d, contacts, isOfLastStep }) {
  const vector = new Float32Array(contacts.point.length), sizes = { force: [], impulse: [] };
  const spans = times.map((t, k) => (k && !isOfLastStep ? t - times[k - 1] : 0));
  for (let k = 0; k < n; k++) {
    for (let c = contacts.start[k]; c < contacts.start[k + 1]; c++) {
      let square = 0;
      for (let j = 0; j < d; j++) {
        const P = contacts.P_N[c] * contacts.normal[c * d + j] + contacts.P_F[c * d + j];
        vector[c * d + j] = spans[k] > 0 ? P / spans[k] : P;
        square += vector[c * d + j] ** 2;
      }
      if (square > 0) sizes[spans[k] > 0 ? "force" : "impulse"].push(Math.sqrt(square));
    }
  }
  const typical = {};
  for (const kind in sizes) typical[kind] = quantile(sizes[kind], 0.9) || 1;
  return { vector, typical, kind: (k) => (spans[k] > 0 ? "force" : "impulse") };
}

function quantile(values, share) {
  return Float64Array.from(values).sort()[Math.floor(share * (values.length - 1))];
}

// The last frame at or before a time.
function frameAt(times, t) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle - 1;
  }
  return low;
}
