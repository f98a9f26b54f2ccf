// A planar film on a canvas: bodies, and the trail of the picked one.

const TOO_SMALL = 1.5; // chosen: pixels: a smaller body is a dot

class Plane {
  constructor(canvas, film) {
    this.canvas = canvas; this.film = film; this.pen = canvas.getContext("2d");
    this.detail = `a body smaller than ${TOO_SMALL} px is a dot`;
    this.bounds = motionBounds(film);
    this.length = Math.max(this.bounds[2] - this.bounds[0], this.bounds[3] - this.bounds[1]);
    this.fit();
  }

  resize(width, height, ratio) {
    [this.width, this.height] = [width, height];
    this.canvas.width = width * ratio; this.canvas.height = height * ratio;
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    if (this.isFitted) this.fit(this.near);
  }

  // All of the motion in view, or so much around what is in its middle.
  fit(near = null) {
    const [x0, y0, x1, y1] = this.bounds, w = this.width ?? 100, h = this.height ?? 100;
    [this.near, this.isFitted] = [near, true];
    if (near) { this.scale = Math.min(w - 80, h - 110) / (2 * near); return; }
    const size = Math.max(x1 - x0, y1 - y0) || 1;
    this.scale = Math.min((w - 80) / Math.max(x1 - x0, size / 50), (h - 110) / Math.max(y1 - y0, size / 50));
    [this.x, this.y] = [(x0 + x1) / 2, (y0 + y1) / 2];
  }

  begin() {} // a planar film has the same pixels whether it plays or not
  hurry() {}
  stand() {}

  // Pixels of a point, and back.
  project([x, y]) { return [this.width / 2 + this.scale * (x - this.x), this.height / 2 - this.scale * (y - this.y)]; }
  get unit() { return 1 / this.scale; } // of length, per pixel
  under(px, py) { return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale]; }

  drag(dx, dy) { this.x -= dx / this.scale; this.y += dy / this.scale; this.isFitted = false; }

  zoom(factor, px, py) {
    const [x, y] = this.under(px, py);
    this.scale *= factor; this.isFitted = false;
    const [x1, y1] = this.under(px, py);
    this.x += x - x1; this.y += y - y1;
  }

  centre(point) { [this.x, this.y] = point; this.isFitted &&= this.near !== null; }

  // The points of a shape in pixels, at a frame.
  place(body, shape, k) {
    const { position, turn, bodies, n } = this.film, at = k * bodies.length + body;
    const isBending = shape.size.length === 3, m = shape.size[shape.size.length - 2], first = isBending ? k * m : 0;
    const c = Math.cos(turn[at]), s = Math.sin(turn[at]), path = new Array(m); // a planar shape but a half-plane has no place of its own
    for (let i = 0; i < m; i++) {
      const x = shape.points[2 * (first + i)], y = shape.points[2 * (first + i) + 1];
      path[i] = this.project([position[2 * at] + c * x - s * y, position[2 * at + 1] + s * x + c * y]);
    }
    return path;
  }

  trace(body, shape, k) {
    const pen = this.pen, path = this.place(body, shape, k), r = shape.radius * this.scale;
    const turn = this.film.turn[k * this.film.bodies.length + body];
    if (shape.kind === "disc") {
      const [x, y] = path[0];
      if (r < TOO_SMALL) return pen.rect(x - 1, y - 1, 2, 2);
      pen.moveTo(x + r, y); pen.arc(x, y, r, 0, 2 * Math.PI, true);
      pen.moveTo(x, y); pen.lineTo(x + r * Math.cos(turn), y - r * Math.sin(turn));
    } else if (shape.kind === "capsule") {
      const [[x0, y0], [x1, y1]] = path, along = Math.atan2(y1 - y0, x1 - x0);
      pen.moveTo(x0 - r * Math.sin(along), y0 + r * Math.cos(along));
      pen.arc(x1, y1, r, along + Math.PI / 2, along - Math.PI / 2, true);
      pen.arc(x0, y0, r, along - Math.PI / 2, along - 1.5 * Math.PI, true);
      pen.closePath();
    } else if (shape.kind === "half-plane") {
      const at = 2 * (k * this.film.bodies.length + body), [u, v, angle] = shape.place ?? [0, 0, 0], C = Math.cos(turn), S = Math.sin(turn);
      const [x, y] = this.project([this.film.position[at] + C * u - S * v, this.film.position[at + 1] + S * u + C * v]);
      const L = 4 * (this.width + this.height + Math.hypot(x, y)), c = Math.cos(turn + angle), s = Math.sin(turn + angle);
      pen.moveTo(x + L * c, y - L * s); pen.lineTo(x - L * c, y + L * s);
      pen.lineTo(x - L * c + L * s, y + L * s + L * c); pen.lineTo(x + L * c + L * s, y - L * s + L * c); pen.closePath();
    } else {
      path.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
      if (shape.kind === "polygon") pen.closePath();
    }
  }

  drawBodies(k, which, style) {
    const pen = this.pen;
    for (const isFilled of [true, false]) { // what is closed, then lines
      pen.beginPath();
      for (const body of which) {
        for (const shape of this.film.bodies[body].shapes) {
          if (isFilled !== isClosed(shape)) continue;
          this.trace(body, shape, k);
        }
      }
      Object.assign(pen, style);
      if (!isFilled) pen.lineWidth = 1.7 * style.lineWidth;
      if (isFilled) pen.fill();
      pen.stroke();
    }
  }

  draw(k, picked, theme) {
    const { pen, film } = this, all = film.bodies.map((_, i) => i);
    pen.clearRect(0, 0, this.width, this.height);
    pen.lineJoin = pen.lineCap = "round";
    this.drawGrid(theme);
    this.drawBodies(k, all.filter((i) => film.bodies[i].fixed), { fillStyle: theme.line, strokeStyle: theme.still, lineWidth: 1.2 });
    this.drawBodies(k, all.filter((i) => film.bodies[i].guided), { fillStyle: `rgba(${theme.guided}, 0.25)`, strokeStyle: `rgb(${theme.guided})`, lineWidth: 1.5 });
    const free = all.filter((i) => isFree(film.bodies[i]) && i !== picked), groups = new Map(), lineWidth = free.length > 200 ? 0.8 : 1.5;
    for (const i of free) {
      const colour = film.colouring.of(i, k, theme) ?? i % 3;
      if (!groups.has(colour)) groups.set(colour, []);
      groups.get(colour).push(i);
    }
    for (const [colour, which] of groups) {
      const isShade = typeof colour === "number";
      this.drawBodies(k, which, { fillStyle: isShade ? `rgba(${theme.body}, ${0.14 + 0.09 * colour})` : `${colour}80`, strokeStyle: isShade ? `rgb(${theme.body})` : colour, lineWidth });
    }
    if (picked !== null) {
      this.drawTrail(k, picked, theme);
      this.drawBodies(k, [picked], { fillStyle: `rgba(${theme.body}, 0.35)`, strokeStyle: theme.picked, lineWidth: 2.4 });
    }
  }

  // Lines at round lengths, so that sizes can be read.
  drawGrid(theme) {
    const pen = this.pen, step = roundUp(90 / this.scale), [x0, y1] = this.under(0, 0), [x1, y0] = this.under(this.width, this.height);
    this.gridStep = step;
    pen.beginPath();
    for (let x = Math.ceil(x0 / step) * step; x <= x1; x += step) { const [px] = this.project([x, 0]); pen.moveTo(px, 0); pen.lineTo(px, this.height); }
    for (let y = Math.ceil(y0 / step) * step; y <= y1; y += step) { const [, py] = this.project([0, y]); pen.moveTo(0, py); pen.lineTo(this.width, py); }
    Object.assign(pen, { strokeStyle: theme.line, lineWidth: 0.5, globalAlpha: 0.6 });
    pen.stroke(); pen.globalAlpha = 1;
  }

  drawTrail(k, body, theme) {
    const { pen, film } = this, n_b = film.bodies.length;
    pen.beginPath();
    for (let i = 0; i <= k; i++) {
      const [x, y] = this.project(film.position.subarray(2 * (i * n_b + body), 2 * (i * n_b + body) + 2));
      if (i) pen.lineTo(x, y); else pen.moveTo(x, y);
    }
    Object.assign(pen, { strokeStyle: theme.picked, lineWidth: 1, globalAlpha: 0.6 });
    pen.stroke(); pen.globalAlpha = 1;
  }

  // The body under the pointer: inside a closed shape, or within some pixels of a line.
  hit(px, py, k, reach = 8) {
    let found = null, nearest = reach;
    this.film.bodies.forEach(({ fixed, shapes }, body) => {
      if (fixed) return;
      for (const shape of shapes) {
        const away = distance([px, py], this.place(body, shape, k), shape, this.scale);
        if (away < nearest) { nearest = away; found = body; }
      }
    });
    return found;
  }

  scaleText() { return `grid ${short(this.gridStep)} m`; }
}

// Pixels from a point to a shape; negative inside.
function distance([x, y], path, shape, scale) {
  if (!path.length) return Infinity;
  if (path.length === 1) return Math.hypot(x - path[0][0], y - path[0][1]) - shape.radius * scale;
  const closed = shape.kind === "polygon" ? [...path, path[0]] : path;
  let away = Infinity, isInside = false;
  for (let i = 1; i < closed.length; i++) {
    const [[x0, y0], [x1, y1]] = [closed[i - 1], closed[i]], L = (x1 - x0) ** 2 + (y1 - y0) ** 2;
    const s = L > 0 ? Math.min(1, Math.max(0, ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / L)) : 0;
    away = Math.min(away, Math.hypot(x - x0 - s * (x1 - x0), y - y0 - s * (y1 - y0)));
    if (y0 > y !== y1 > y && x < x0 + ((y - y0) / (y1 - y0)) * (x1 - x0)) isInside = !isInside;
  }
  return (shape.kind === "polygon" && isInside ? -1 : away) - shape.radius * scale;
}

// The box of the whole motion, of 100 frames at most: [x0, y0, x1, y1].
function motionBounds(film) {
  const box = [Infinity, Infinity, -Infinity, -Infinity], n_b = film.bodies.length, stride = Math.ceil(film.n / 100);
  const take = (x, y, r) => {
    box[0] = Math.min(box[0], x - r); box[1] = Math.min(box[1], y - r);
    box[2] = Math.max(box[2], x + r); box[3] = Math.max(box[3], y + r);
  };
  const areAllFixed = film.bodies.every((body) => body.fixed);
  for (let k = 0; k < film.n; k += stride) {
    film.bodies.forEach((body, b) => {
      if (body.fixed && !areAllFixed) return;
      const at = k * n_b + b, [X, Y] = film.position.subarray(2 * at, 2 * at + 2), c = Math.cos(film.turn[at]), s = Math.sin(film.turn[at]);
      for (const shape of body.shapes) {
        const m = shape.size[shape.size.length - 2], first = shape.size.length === 3 ? k * m : 0;
        for (let i = first; i < first + m; i++) {
          const [x, y] = shape.points.subarray(2 * i, 2 * i + 2);
          take(X + c * x - s * y, Y + s * x + c * y, shape.radius);
        }
      }
    });
  }
  for (let c = 0; c < film.contacts.number.length; c += Math.ceil(film.contacts.number.length / 1000)) {
    take(film.contacts.point[2 * c], film.contacts.point[2 * c + 1], 0);
  }
  return box[0] <= box[2] ? box : [-1, -1, 1, 1];
}

function isClosed({ kind, points, size }) {
  if (kind !== "bending polyline") return kind !== "polyline";
  const last = 2 * (size[1] - 1), scale = Math.max(...points.subarray(0, last + 2).map(Math.abs));
  return Math.hypot(points[0] - points[last], points[1] - points[last + 1]) < 1e-5 * scale;
}

// The next of 1, 2, 5 times a power of ten.
function roundUp(x) {
  const ten = 10 ** Math.floor(Math.log10(x));
  return ten * [1, 2, 5, 10].find((m) => m * ten >= x * (1 - 1e-9));
}

function short(x) { return Number(x.toPrecision(4)).toString(); }
