// Contacts, their forces and their cones, drawn over the scene in the plane and in space: `stage` projects and says how
// long a pixel is where the motion is.

const ARROW = 55, LONGEST = 110, CONE = 46; // chosen: pixels of a typical force, of the longest arrow, of a cone
const SOME = 12, LEAST = 0.25; // chosen: contacts in a frame: of more, arrows and cones are as long as a usual body reaches, down to this share; points are small without them
const MANY = 300; // chosen: contacts in a frame: of more, cones, heads and open ones are left out, and arrows are a third as long
const MOST_ARROWS = 1500; // chosen: of more contacts every second, third, ... is drawn
const RIM = 14; // chosen: corners of a cone's rim in space
const CONTACT_DETAIL = `cones, heads and open contacts up to ${MANY} closed contacts (${SOME} without forces), points and arrows of at most ${MOST_ARROWS}`;

class ContactLayer {
  constructor(canvas, film, stage) { Object.assign(this, { canvas, film, stage, pen: canvas.getContext("2d"), hasForces: true }); }

  resize(width, height, ratio) {
    this.canvas.width = width * ratio; this.canvas.height = height * ratio;
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    [this.width, this.height] = [width, height];
  }

  draw(k, theme) {
    const { contacts } = this.film, first = contacts.start[k], last = contacts.start[k + 1];
    this.wasCrowd = false;
    this.pen.clearRect(0, 0, this.width, this.height);
    this.pen.lineJoin = this.pen.lineCap = "round";
    const every = Math.ceil((last - first) / MOST_ARROWS) || 1, open = [], closed = [];
    for (let c = first; c < last; c += every) (contacts.mode[c] ? closed : open).push(c);
    this.wasCrowd = closed.length > (this.hasForces ? MANY : SOME);
    this.share = closed.length > SOME ? Math.min(1, Math.max(LEAST, this.film.usualReach / this.stage.unit / ARROW)) : 1;
    if (this.wasCrowd) return this.drawCrowd(closed, k);
    for (const c of open) this.drawPoint(c, theme, 2.8 * Math.sqrt(this.share));
    if (this.hasForces) for (const c of closed) this.drawCone(c);
    for (const c of closed) this.drawPoint(c, theme, 4.2 * Math.sqrt(this.share));
    if (this.hasForces) for (const c of [...open, ...closed]) this.drawArrow(c, k, theme); // open again after an impact
  }

  // Pixels of a typical force.
  get arrow() { return this.wasCrowd ? ARROW / 3 : ARROW * this.share; }

  // Many contacts: one path for each colour.
  drawCrowd(closed, k) {
    const pen = this.pen, { forces } = this.film, typical = forces.typical[forces.kind(k)];
    pen.lineCap = "butt"; // lines of one pixel without caps are what software draws fastest
    for (const mode of this.film.modes) {
      const those = closed.filter((c) => this.film.modeOf(c) === mode);
      Object.assign(pen, { strokeStyle: mode[3], fillStyle: mode[3], lineWidth: 1 });
      pen.beginPath();
      for (const c of those) {
        const [x, y] = this.stage.project(this.at(c));
        pen.fillRect(x - 1.5, y - 1.5, 3, 3);
        if (!this.hasForces) continue;
        const F = this.vector(forces.vector, c), size = Math.hypot(...F), pixels = Math.min((this.arrow * size) / typical, LONGEST / 3);
        if (!(pixels > 2)) continue;
        pen.moveTo(x, y);
        pen.lineTo(...this.away(c, F.map((f) => f / size), pixels));
      }
      pen.stroke();
    }
  }

  vector(values, c) { return this.film.dimension === 2 ? [values[2 * c], values[2 * c + 1]] : [values[3 * c], values[3 * c + 1], values[3 * c + 2]]; }
  at(c) { return this.vector(this.film.contacts.point, c); }

  // Pixels of the point so many pixels away from the contact.
  away(c, direction, pixels) { return this.stage.project(this.at(c).map((x, j) => x + direction[j] * pixels * this.stage.unit)); }

  drawPoint(c, theme, radius = 2.8) {
    const pen = this.pen, [x, y] = this.stage.project(this.at(c)), isOpen = this.film.contacts.mode[c] === 0;
    pen.beginPath();
    pen.arc(x, y, radius, 0, 2 * Math.PI);
    Object.assign(pen, { fillStyle: isOpen ? theme.ground : this.film.modeOf(c)[3], strokeStyle: isOpen ? theme.still : theme.halo, lineWidth: 1.2 });
    pen.fill(); pen.stroke();
  }

  // The cone of forces |P_F| <= mu P_N, on the side that the force acts to: two rays, in space with a rim.
  drawCone(c) {
    const { contacts, dimension } = this.film, pen = this.pen, mu = contacts.mu[c];
    if (!(mu > 0)) return;
    const side = contacts.P_N[c] < 0 ? -1 : 1, n = this.vector(contacts.normal, c), size = Math.hypot(1, mu);
    const across = dimension === 2 ? [[n[1], -n[0]], [-n[1], n[0]]] : circleAround(n);
    const rim = across.map((t) => this.away(c, n.map((x, j) => (side * x + mu * t[j]) / size), CONE * this.share)), tip = this.stage.project(this.at(c));
    const colour = this.film.modeOf(c)[3];
    pen.beginPath();
    for (const point of dimension === 2 ? [tip, ...rim] : rim) pen.lineTo(...point);
    pen.closePath();
    Object.assign(pen, { fillStyle: colour, strokeStyle: colour, lineWidth: 1, globalAlpha: 0.16 });
    pen.fill(); pen.globalAlpha = 0.8;
    if (dimension === 3) pen.stroke();
    pen.beginPath();
    for (const point of rim) { pen.moveTo(...tip); pen.lineTo(...point); }
    if (dimension === 3) pen.globalAlpha = 0.35;
    pen.stroke(); pen.globalAlpha = 1;
  }

  // The force upon the body since the frame before; two heads where it is larger than the arrow.
  drawArrow(c, k, theme) {
    const { forces } = this.film, pen = this.pen, kind = forces.kind(k), F = this.vector(forces.vector, c), size = Math.hypot(...F);
    const pixels = Math.min((this.arrow * size) / forces.typical[kind], LONGEST * this.share);
    if (!(pixels > 2)) return;
    const [x, y] = this.stage.project(this.at(c)), [x1, y1] = this.away(c, F.map((f) => f / size), pixels);
    const length = Math.hypot(x1 - x, y1 - y), [ex, ey] = [(x1 - x) / (length || 1), (y1 - y) / (length || 1)], head = Math.min(9 * Math.sqrt(this.share), length);
    const colour = this.film.contacts.mode[c] ? this.film.modeOf(c)[3] : theme.ink;
    const widths = kind === "impulse" && !this.film.isOfLastStep ? [[theme.halo, 6], [colour, 3.6]] : [[theme.halo, 4.5], [colour, 2.2]];
    for (const [strokeStyle, fullWidth] of widths) {
      const lineWidth = fullWidth * Math.sqrt(this.share);
      pen.beginPath();
      pen.moveTo(x, y); pen.lineTo(x1, y1);
      for (const tip of pixels < LONGEST * this.share ? [length] : [length, length - 7]) {
        for (const side of [-0.45, 0.45]) {
          pen.moveTo(x + tip * ex, y + tip * ey);
          pen.lineTo(x + (tip - head) * ex - side * head * ey, y + (tip - head) * ey + side * head * ex);
        }
      }
      Object.assign(pen, { strokeStyle, lineWidth });
      pen.stroke();
    }
  }
}

// Unit vectors around a normal.
function circleAround([x, y, z]) {
  const [ax, ay, az] = Math.abs(x) < 0.6 ? [0, -z, y] : [z, 0, -x], size = Math.hypot(ax, ay, az);
  const a = [ax / size, ay / size, az / size], b = [y * a[2] - z * a[1], z * a[0] - x * a[2], x * a[1] - y * a[0]];
  return Array.from({ length: RIM }, (_, i) => a.map((value, j) => Math.cos((2 * Math.PI * i) / RIM) * value + Math.sin((2 * Math.PI * i) / RIM) * b[j]));
}
