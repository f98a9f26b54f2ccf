// What the free bodies are coloured by: alike, each its own, their material, or how fast their centres go.

const COLOURINGS = { plain: "one colour", body: "by body", material: "by material", speed: "by speed" };
const RAMP = ["#414487", "#2a788e", "#22a884", "#7ad151", "#e5c100"]; // chosen: from rest to the greatest speed
const SPEEDS = 17; // chosen: colours of speeds

class Colouring {
  constructor(film) {
    Object.assign(this, { film, by: "plain", materials: [...new Set(film.bodies.filter(isFree).map(({ material }) => material))] });
    this.choices = Object.keys(COLOURINGS).filter((by) => by !== "material" || this.materials.length > 1);
  }

  // Those of the theme: of bodies and materials the cycle of the figures without its greys.
  themed(seen) {
    const hues = this.film.cycle.filter((colour) => colour.slice(1, 3) !== colour.slice(3, 5)).map(seen);
    return { hues, speeds: Array.from({ length: SPEEDS }, (_, i) => seen(mixed(RAMP, i / (SPEEDS - 1)))) };
  }

  // Of a free body at a frame; none where all are alike.
  of(body, k, { hues, speeds }) {
    if (this.by === "body") return hues[body % hues.length];
    if (this.by === "material") return hues[this.materials.indexOf(this.film.bodies[body].material) % hues.length];
    return this.by === "speed" ? speeds[Math.round(((SPEEDS - 1) * this.speeds[k * this.film.bodies.length + body]) / (this.fastest || 1))] : null;
  }

  // Of each body at each frame the mean since the frame before; at an instant that of the frame before it.
  get speeds() {
    if (this.known) return this.known;
    const { film } = this, { n, times, dimension: d, position } = film, n_b = film.bodies.length;
    this.known = new Float32Array(n * n_b);
    for (let k = 1; k < n; k++) {
      for (let b = 0, at = k * n_b; b < n_b; b++, at++) {
        let square = 0;
        for (let j = 0; j < d; j++) square += (position[d * at + j] - position[d * (at - n_b) + j]) ** 2;
        this.known[at] = times[k] > times[k - 1] ? Math.sqrt(square) / (times[k] - times[k - 1]) : this.known[at - n_b];
      }
    }
    if (n > 1) this.known.copyWithin(0, n_b, 2 * n_b);
    return this.known;
  }

  get fastest() { return (this.greatest ??= this.speeds.reduce((most, v, at) => (isFree(this.film.bodies[at % this.film.bodies.length]) ? Math.max(most, v) : most), 0)); }

  // Colours and words for the legend.
  legend({ hues, speeds }) {
    if (this.by === "material") return this.materials.map((material, i) => [[hues[i % hues.length]], material]);
    return this.by === "speed" ? [[speeds, `speed of the centre, 0 to ${short(this.fastest)} m/s`]] : [];
  }
}

function isFree({ fixed, guided }) { return !fixed && !guided; }

// A colour within a ramp, 0 <= share <= 1.
function mixed(ramp, share) {
  const at = Math.min(ramp.length - 2, Math.floor(share * (ramp.length - 1))), part = share * (ramp.length - 1) - at;
  const [low, high] = [ramp[at], ramp[at + 1]].map((text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16)));
  return `#${low.map((x, j) => Math.round(x + part * (high[j] - x)).toString(16).padStart(2, "0")).join("")}`;
}
