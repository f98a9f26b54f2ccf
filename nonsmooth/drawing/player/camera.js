// What a camera that follows what moves looks at: of each frame the middle of the free bodies, and how wide a view they need.

const AWAY = 4; // chosen: of the middle distance from the middle: a body that is ever farther runs away, and is left out
const NARROW = 5; // chosen: of how far a body reaches: no view is narrower
const LOST = 4; // chosen: a view of all of the motion that is so much wider loses the bodies: the camera follows from the start

class Moving {
  constructor(film) {
    Object.assign(this, { film, radius: 0, those: film.bodies.flatMap((body, b) => (isFree(body) ? [b] : [])) });
    if (!this.those.length) return;
    const frames = [...Array(film.n).keys()].filter((k) => k % Math.ceil(film.n / 100) === 0 || k === film.n - 1), away = new Set();
    for (const k of frames) {
      const far = this.distances(k), most = AWAY * median(far);
      far.forEach((distance, i) => { if (distance > most) away.add(this.those[i]); });
    }
    if (away.size < this.those.length) this.those = this.those.filter((b) => !away.has(b));
    this.radius = Math.max(NARROW * film.usualReach, ...frames.map((k) => Math.max(...this.distances(k))));
  }

  at(k, b) { return this.film.dimension * (k * this.film.bodies.length + b); }
  middle(k) { return Array.from({ length: this.film.dimension }, (_, j) => median(this.those.map((b) => this.film.position[this.at(k, b) + j]))); }

  // How far each body reaches from the middle.
  distances(k) {
    const middle = this.middle(k);
    return this.those.map((b) => this.film.usualReach + Math.hypot(...middle.map((x, j) => this.film.position[this.at(k, b) + j] - x)));
  }

  // Whether in a view of so much the bodies are lost.
  isLostIn(length) { return this.radius > 0 && length > 2 * LOST * this.radius; }
}

function median(values) {
  const sorted = Float64Array.from(values).sort(), half = sorted.length >> 1;
  return sorted.length % 2 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
}
