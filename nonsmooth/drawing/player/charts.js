// The time line with modes and events, and curves, over one axis of time. A chart is drawn once; its cursor moves.

const LEFT = 62, RIGHT = 14, TOP = 18, BOTTOM = 17; // chosen: pixels around the axes; the same for all, so that times stand below each other
const FLOAT32 = 2 ** -23; // defined: relative
const STRIPS = 6; // chosen: contacts with a strip of their own; of more, the share of each mode
const STRIP = 17; // chosen: pixels of its height
const FLAT = 1e-6; // chosen: of its scale: a curve that varies less is drawn as the constant it is
const NEAR = 7; // chosen: pixels between the pointer and an event that it names

class Chart {
  constructor(box, film) {
    this.box = box; this.film = film;
    this.canvas = box.querySelector("canvas"); this.cursor = box.querySelector(".cursor");
    this.pen = this.canvas.getContext("2d");
    this.t0 = film.times[0]; this.t1 = film.times[film.n - 1];
    this.top = TOP;
  }

  resize(ratio) {
    const { width, height } = this.box.getBoundingClientRect();
    [this.width, this.height] = [width, height];
    this.canvas.width = width * ratio; this.canvas.height = height * ratio;
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  }

  x(t) { return LEFT + ((this.width - LEFT - RIGHT) * (t - this.t0)) / (this.t1 - this.t0 || 1); }
  timeAt(x) { return this.t0 + ((this.t1 - this.t0) * Math.min(1, Math.max(0, (x - LEFT) / (this.width - LEFT - RIGHT)))); }
  point(t) { this.cursor.style.transform = `translateX(${this.x(t)}px)`; }

  drawTimes(theme) {
    const pen = this.pen, step = roundUp(((this.t1 - this.t0) * 90) / this.width || 1);
    Object.assign(pen, { fillStyle: theme.faint, strokeStyle: theme.line, lineWidth: 1, font: "11px system-ui, sans-serif", textAlign: "center", textBaseline: "top" });
    for (let m = Math.ceil(this.t0 / step - 1e-9); m * step <= this.t1 + 1e-9 * step; m++) {
      const x = this.x(m * step);
      pen.beginPath(); pen.moveTo(x, this.top); pen.lineTo(x, this.height - BOTTOM); pen.stroke();
      pen.fillText(tick(m * step), x, this.height - BOTTOM + 3);
    }
    pen.textAlign = "right";
    pen.fillText("t [s]", LEFT - 22, this.height - BOTTOM + 3);
  }
}

class TimeLine extends Chart {
  constructor(box, film) {
    super(box, film);
    this.numbers = [...new Set(film.contacts.number)].sort((a, b) => a - b);
    const strips = this.numbers.length > STRIPS ? 3 : this.numbers.length;
    box.style.height = `${TOP + 14 + STRIP * strips + BOTTOM}px`;
  }

  draw(theme) {
    const { pen } = this;
    pen.clearRect(0, 0, this.width, this.height);
    this.drawTimes(theme);
    const { numbers } = this, top = TOP + 14, height = this.height - BOTTOM - top;
    if (numbers.length > STRIPS) this.drawShares(top, height, theme);
    else numbers.forEach((number, i) => this.drawStrip(number, i, numbers.length, top, height / numbers.length, theme));
    this.drawMarks(theme);
  }

  // Intervals of equal mode of one contact: the mode of a frame lasts from the frame before.
  drawStrip(number, i, of, top, height, theme) {
    const { pen, film } = this, { contacts, times, n } = film, y = top + i * height;
    const modes = new Array(n).fill(null);
    for (let k = 0; k < n; k++) {
      for (let c = contacts.start[k]; c < contacts.start[k + 1]; c++) if (contacts.number[c] === number) modes[k] = film.modeOf(c);
    }
    for (let k = 1, from = 1; k <= n; k++) {
      if (k < n && modes[k] === modes[from]) continue;
      if (from < n && modes[from]) {
        const x = this.x(times[from - 1]);
        pen.fillStyle = modes[from][3];
        pen.fillRect(x, y + 1, Math.max(1, this.x(times[k - 1]) - x), Math.max(2, height - 2));
      }
      from = k;
    }
    Object.assign(pen, { fillStyle: theme.faint, textAlign: "right", textBaseline: "middle" });
    pen.fillText(of > 1 ? `contact ${number}` : "mode", LEFT - 6, y + height / 2);
  }

  // Of many contacts how many are in each mode.
  drawShares(top, height, theme) {
    const { pen, film } = this, { contacts, times, n } = film;
    const most = Math.max(1, ...contacts.start.subarray(1).map((end, k) => end - contacts.start[k]));
    for (let k = 1; k < n; k++) {
      const counts = new Map(film.modes.map((mode) => [mode, 0])), x = this.x(times[k - 1]);
      for (let c = contacts.start[k]; c < contacts.start[k + 1]; c++) counts.set(film.modeOf(c), counts.get(film.modeOf(c)) + 1);
      let y = top + height;
      for (const mode of [...film.modes].reverse()) {
        const size = (height * counts.get(mode)) / most;
        pen.fillStyle = mode[3];
        pen.fillRect(x, y - size, Math.max(1, this.x(times[k]) - x + 0.5), size);
        y -= size;
      }
    }
    Object.assign(pen, { fillStyle: theme.faint, textAlign: "right", textBaseline: "middle" });
    pen.fillText(`${most}`, LEFT - 6, top + 5); pen.fillText("contacts", LEFT - 6, top + Math.max(17, height / 2));
  }

  drawMarks(theme) {
    const { pen, film } = this;
    let free = -Infinity;
    for (const mark of film.marks) {
      const x = this.x(mark.t), y = TOP + 6;
      Object.assign(pen, { strokeStyle: mark.isParadox ? theme.paradox : theme.faint, fillStyle: mark.isParadox ? theme.paradox : theme.faint, lineWidth: mark.isParadox ? 2 : 1 });
      pen.beginPath(); markPath(pen, mark.kind, x, y);
      if (["inconsistent", "impact", "user event"].includes(mark.kind)) pen.fill(); else pen.stroke();
      if (!mark.isParadox) continue;
      const label = `→ ${mark.choice}`, wide = pen.measureText(label).width, start = Math.min(x - 4, this.width - wide - 4);
      if (start < free) continue;
      Object.assign(pen, { textAlign: "left", textBaseline: "alphabetic" });
      pen.fillText(label, start, TOP - 4);
      free = start + wide + 10;
    }
  }

  markNear(x) {
    const away = (mark) => Math.abs(this.x(mark.t) - x) - (mark.isParadox ? 1 : 0); // of two at one place the paradox
    const nearest = this.film.marks.reduce((best, mark) => (best && away(best) <= away(mark) ? best : mark), null);
    return nearest && away(nearest) <= NEAR ? nearest : null;
  }
}

function markPath(pen, kind, x, y) {
  if (kind === "inconsistent") { pen.moveTo(x - 5, y - 5); pen.lineTo(x + 5, y - 5); pen.lineTo(x, y + 5); pen.closePath(); }
  else if (kind === "indeterminate") { pen.moveTo(x, y - 6); pen.lineTo(x, y + 6); }
  else if (kind === "impact") { pen.moveTo(x - 3.5, y + 4); pen.lineTo(x + 3.5, y + 4); pen.lineTo(x, y - 4); pen.closePath(); }
  else if (kind === "user event") pen.rect(x - 3, y - 3, 6, 6);
  else { pen.moveTo(x, y + 1); pen.lineTo(x, y + 6); }
}

class Curves extends Chart {
  constructor(box, film, group) {
    super(box, film);
    this.select = box.querySelector("select"); this.keyLine = box.querySelector(".key");
    this.group = group; this.own = [];
    this.fill();
  }

  // The groups that can be chosen; `own` are those of the picked body.
  fill() {
    const groups = [...new Set([...this.film.curves, ...this.own].map((curve) => curve.group))];
    this.select.replaceChildren(...groups.map((group) => new Option(group, group, false, group === this.group)));
    this.select.hidden = groups.length === 0;
    if (!groups.includes(this.group)) this.group = groups[0];
  }

  curves() { return [...this.film.curves, ...this.own].filter((curve) => curve.group === this.group); }

  draw(theme) {
    const { pen } = this, curves = this.curves(), [low, high, isCut] = range(curves, this.lengthOf(curves[0]));
    pen.clearRect(0, 0, this.width, this.height);
    if (!curves.length) return;
    this.note = isCut ? "peaks leave the axis" : "";
    this.tell(this.film.n - 1, theme);
    const { top, bottom } = this.keyLine.getBoundingClientRect(), box = this.box.getBoundingClientRect();
    this.top = top < box.bottom - 1 ? Math.max(TOP, bottom - box.top + 2) : TOP; // below the words, where these are not below the chart
    this.drawTimes(theme);
    const y = (value) => this.top + ((this.height - this.top - BOTTOM) * (high - value)) / (high - low);
    const step = roundUp(((high - low) * 16) / (this.height - this.top - BOTTOM));
    Object.assign(pen, { textAlign: "right", textBaseline: "middle" });
    for (let m = Math.ceil(low / step); m * step <= high; m++) {
      pen.beginPath(); pen.moveTo(LEFT, y(m * step)); pen.lineTo(this.width - RIGHT, y(m * step)); pen.stroke();
      pen.fillText(tick(m * step), LEFT - 6, y(m * step));
    }
    pen.fillText(`[${curves[0].unit || "–"}]`, LEFT - 6, 9);
    pen.save();
    pen.beginPath(); pen.rect(LEFT, this.top - 2, this.width - LEFT - RIGHT, this.height - this.top - BOTTOM + 4); pen.clip();
    curves.forEach((curve, i) => this.trace(curve, y, theme.colourOf(curve, i), i < theme.curves.length ? [] : [5, 3]));
    pen.restore();
  }

  // The length that gaps and places are measured by: that of the motion.
  lengthOf(curve) { return curve?.unit === "m" && curve.group !== "penetration" ? this.film.length ?? 0 : 0; }

  trace({ values, dashes = [] }, y, strokeStyle, others) {
    const { pen, film } = this;
    pen.beginPath();
    let isDown = false;
    for (let k = 0; k < film.n; k++) {
      if (Number.isNaN(values[k])) { isDown = false; continue; }
      if (isDown) pen.lineTo(this.x(film.times[k]), y(values[k])); else pen.moveTo(this.x(film.times[k]), y(values[k]));
      isDown = true;
    }
    Object.assign(pen, { strokeStyle, lineWidth: 1.6 });
    pen.setLineDash(dashes.length ? dashes.map((length) => 1.6 * length) : others); pen.stroke(); pen.setLineDash([]);
  }

  // Names and values at a frame.
  tell(k, theme) {
    const items = this.curves().map((curve, i) => {
      const item = document.createElement("span");
      item.style.color = theme.colourOf(curve, i);
      item.textContent = `${curve.name} ${Number.isNaN(curve.values[k]) ? "–" : Number.isInteger(curve.values[k]) ? curve.values[k] : figure(curve.values[k], Math.max(curve.scale ?? 0, this.lengthOf(curve)))}`;
      return item;
    });
    if (this.note) items.push(Object.assign(document.createElement("span"), { textContent: this.note }));
    this.keyLine.replaceChildren(...items);
  }
}

// [low, high, whether peaks are cut] of curves; a constant, to a millionth of its scale, is shown as one.
function range(curves, length) {
  const values = curves.flatMap((curve) => Array.from(curve.values)).filter((value) => Number.isFinite(value));
  if (!values.length) return [-1, 1, false];
  values.sort((a, b) => a - b);
  let [low, high] = [values[0], values[values.length - 1]];
  const [q0, q1] = [quantile(values, 0.01), quantile(values, 0.99)], usual = Math.max(Math.abs(q0), Math.abs(q1));
  const isForce = curves[0].group === "forces", isCut = isForce && Math.max(-low, high) > 4 * usual && usual > 0;
  if (isCut) [low, high] = [Math.max(low, -1.3 * usual), Math.min(high, 1.3 * usual)];
  const scale = Math.max(length, ...curves.map((curve) => curve.scale ?? 0)), size = Math.max(Math.abs(low), Math.abs(high), scale) || 1;
  if (high - low < FLAT * size) [low, high] = scale ? [Math.min(-0.1 * size, 1.2 * low), Math.max(0.1 * size, 1.2 * high)] : [Math.min(0, 1.2 * low), Math.max(0, 1.2 * high) || 1];
  const margin = 0.06 * (high - low);
  return [low - margin, high + margin, isCut];
}

function tick(x) {
  const text = short(x);
  return text.length > 7 ? Number(text).toExponential() : text;
}

// Four figures; 0 where float32, in which a film is kept, has no more of a quantity of that scale.
function figure(x, scale = 0) {
  const size = Math.abs(x);
  if (size < FLOAT32 * scale) return "0";
  return size && (size < 1e-3 || size >= 1e5) ? x.toExponential(3) : x.toPrecision(4);
}
