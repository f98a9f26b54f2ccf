// The player: time, keys, pointer, what is told beside the scene, and `window.player`, by which a test or a script reads it.

const USUAL = [3, 25]; // chosen: seconds: a motion that lasts as long is played at its own speed
const SHOWN = 10; // chosen: seconds that another one is played in
const TOLD = 12; // chosen: contacts in the table
const FEW = 20; // chosen: moving bodies: of more the arrows and cones hide the bodies, and are shown when asked for
const SHORT = 700; // chosen: pixels: in a window that is less high the second curves are those of the picked body
const FLUENT = 30; // chosen: pictures a second; where there are fewer, the stage is asked to hurry
const WATCHED = 10; // chosen: pictures between two looks at their rate
const CONTRAST = 4; // chosen: of a mode or a curve with a dark ground; WCAG 2.1 asks 3 of graphics
const SHARE = [1, 2, 5]; // chosen: steps of the speed within a power of ten

const $ = (id) => document.getElementById(id);
const element = (name, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
};

class Player {
  constructor(film, stage) {
    this.layer = new ContactLayer($("overlay"), film, stage);
    film.length = stage.length;
    this.layer.hasForces = film.bodies.filter(isFree).length <= FEW;
    Object.assign(this, { film, stage, frame: 0, time: film.times[0], isPlaying: false, picked: null, isFollowing: false, drawn: [] });
    const span = film.times[film.n - 1] - film.times[0];
    this.speed = span >= USUAL[0] && span <= USUAL[1] ? 1 : roundUp((span || 1) / SHOWN);
    const boxes = document.querySelectorAll("#charts .chart");
    this.timeLine = new TimeLine(boxes[0], film);
    const groups = [...new Set(film.curves.map((curve) => curve.group))];
    this.curves = [new Curves(boxes[1], film, groups[0]), new Curves(boxes[2], film, groups[1] ?? groups[0])];
    this.charts = [this.timeLine, ...this.curves];
    this.hasOneGroup = groups.length < 2;
    $("colours").replaceChildren(...film.colouring.choices.map((by) => new Option(COLOURINGS[by], by)));
    this.write();
    this.listen();
    this.setDark(matchMedia("(prefers-color-scheme: dark)").matches);
    new ResizeObserver(() => this.resize()).observe($("scene"));
    this.resize();
    if (film.moving.isLostIn(film.length)) this.follow(true);
  }

  // --- time

  play() {
    if (this.isPlaying) return;
    if (this.frame === this.film.n - 1) this.seek(this.film.times[0]);
    this.isPlaying = true;
    this.drawn = [];
    this.stage.begin();
    let last = performance.now(), counted = 0;
    const tick = (now) => {
      if (!this.isPlaying) return;
      this.time += ((now - last) / 1000) * this.speed;
      last = now;
      if (this.time >= this.film.times[this.film.n - 1]) this.pause();
      this.show(frameAt(this.film.times, this.time));
      this.drawn.push(now);
      if (this.drawn.length - counted > WATCHED) {
        if (now - this.drawn[counted] > (1000 * WATCHED) / FLUENT) this.stage.hurry();
        counted = this.drawn.length;
      }
      if (this.isPlaying) requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
    this.tellPlay();
  }

  pause() {
    if (this.isPlaying) this.stage.stand();
    this.isPlaying = false;
    this.tellPlay();
  }

  seek(t) {
    this.time = Math.min(Math.max(t, this.film.times[0]), this.film.times[this.film.n - 1]);
    this.show(frameAt(this.film.times, this.time));
  }

  goTo(frame) {
    this.pause();
    frame = Math.min(Math.max(frame, 0), this.film.n - 1);
    this.time = this.film.times[frame];
    this.show(frame);
  }

  step(by) { this.goTo(this.frame + by); }

  nextEvent() { const mark = this.film.marks.find(({ frame }) => frame > this.frame); if (mark) this.goTo(mark.frame); }
  previousEvent() { const mark = this.film.marks.findLast(({ frame }) => frame < this.frame); if (mark) this.goTo(mark.frame); }

  changeSpeed(by) {
    const ten = Math.floor(Math.log10(this.speed) + 1e-9), at = 3 * ten + SHARE.findLastIndex((m) => m <= (this.speed / 10 ** ten) * (1 + 1e-9)) + by;
    this.speed = Number((SHARE[((at % 3) + 3) % 3] * 10 ** Math.floor(at / 3)).toPrecision(2));
    this.tellPlay();
  }

  // Frames drawn a second while it played.
  rate() { const n = this.drawn.length; return n > 1 ? (1000 * (n - 1)) / (this.drawn[n - 1] - this.drawn[0]) : 0; }

  // --- what is shown

  show(frame) {
    this.frame = frame;
    if (this.isFollowing) this.stage.centre(this.picked === null ? this.film.moving.middle(frame) : this.positionOf(this.picked));
    this.redraw();
    const t = this.isPlaying ? this.time : this.film.times[frame];
    this.charts.forEach((chart) => chart.point(t));
    this.tell();
  }

  redraw() { this.stage.draw(this.frame, this.picked, this.theme); this.layer.draw(this.frame, this.theme); $("scale").textContent = this.scaleText(); }

  // What is seen, as one picture: a canvas in space keeps its content until the end of the task that drew it.
  picture() {
    this.redraw();
    const canvas = document.createElement("canvas"), below = $("stage");
    [canvas.width, canvas.height] = [below.width, below.height];
    const pen = canvas.getContext("2d");
    pen.fillStyle = this.theme.ground;
    pen.fillRect(0, 0, canvas.width, canvas.height);
    for (const layer of [below, $("overlay")]) pen.drawImage(layer, 0, 0, canvas.width, canvas.height);
    return canvas;
  }

  save() {
    const link = document.createElement("a");
    link.download = `${document.title} ${this.film.times[this.frame].toFixed(6)} s.png`;
    link.href = this.picture().toDataURL("image/png");
    link.click();
  }

  scaleText() {
    const { typical, kind: kindOf } = this.film.forces, start = this.film.contacts.start, hasContacts = start[this.film.n] > 0;
    const kind = kindOf(this.frame), unit = kind === "force" ? "N" : "N s";
    return this.stage.scaleText() + (hasContacts && this.layer.hasForces ? `\narrow of ${Math.round(this.layer.arrow)} px: ${short(Number(typical[kind].toPrecision(2)))} ${unit}` : "");
  }

  resize() {
    this.curves[1].box.hidden = (this.hasOneGroup || innerHeight < SHORT) && this.picked === null;
    const { width, height } = $("scene").getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
    if (!width || !height) return;
    this.stage.resize(width, height, ratio);
    this.layer.resize(width, height, ratio);
    this.charts.forEach((chart) => { chart.resize(ratio); chart.draw(this.theme); });
    this.show(this.frame);
  }

  setDark(isDark) {
    document.documentElement.classList.toggle("dark", isDark);
    const style = getComputedStyle(document.documentElement), colour = (name) => style.getPropertyValue(`--${name}`).trim();
    this.theme = Object.fromEntries(["ground", "panel", "ink", "faint", "line", "still", "body", "guided", "picked", "halo", "paradox"].map((name) => [name, colour(name)]));
    const seen = (printed) => (isDark ? seenOn(printed, this.theme.ground) : printed);
    this.theme.curves = this.film.cycle.map(seen);
    this.theme.colourOf = (curve, i) => (curve.colour ? seen(curve.colour) : this.theme.curves[i % this.theme.curves.length]);
    Object.assign(this.theme, this.film.colouring.themed(seen));
    for (const mode of this.film.modes) mode[3] = mode[0] || !isDark ? seen(mode[4]) : this.theme.line;
    this.isDark = isDark;
    this.writeLegend();
    this.resize();
  }

  setColours(by) {
    if (!this.film.colouring.choices.includes(by)) throw new RangeError(`bodies have no colours ${by}; see player.colourings`);
    this.film.colouring.by = $("colours").value = by;
    this.writeLegend();
    this.redraw();
  }

  nextColours() { const { choices, by } = this.film.colouring; this.setColours(choices[(choices.indexOf(by) + 1) % choices.length]); }

  positionOf(body) {
    const d = this.film.dimension, at = d * (this.frame * this.film.bodies.length + body);
    return Array.from(this.film.position.subarray(at, at + d));
  }

  // Mean velocity since the frame before, in as many figures as float32 leaves of the way; none at an instant.
  velocityOf(body) {
    const { film, frame } = this, span = frame ? film.times[frame] - film.times[frame - 1] : 0, d = film.dimension, at = d * (frame * film.bodies.length + body);
    if (!(span > 0)) return [];
    const least = (FLOAT32 * film.length) / span;
    return Array.from({ length: d }, (_, j) => {
      const v = (film.position[at + j] - film.position[at + j - d * film.bodies.length]) / span, figures = Math.floor(Math.log10(Math.abs(v) / least));
      return figures < 1 ? "0" : Number(v.toPrecision(Math.min(4, figures))).toString();
    });
  }

  turnOf(body) {
    const size = this.film.dimension === 3 ? 4 : 1, at = size * (this.frame * this.film.bodies.length + body);
    return Array.from(this.film.turn.subarray(at, at + size));
  }

  pick(body) {
    this.picked = body;
    for (const curves of this.curves) { curves.own = body === null ? [] : this.curvesOf(body); curves.fill(); }
    if (body !== null) { this.curves[1].group = "picked body: position"; this.curves[1].fill(); }
    this.resize();
  }

  // Position and angle, or quaternion, of a body over the frames.
  curvesOf(body) {
    const { film } = this, d = film.dimension, n_b = film.bodies.length, size = d === 3 ? 4 : 1;
    const column = (values, width, j) => Float64Array.from({ length: film.n }, (_, k) => values[width * (k * n_b + body) + j]);
    const position = ["x", "y", "z"].slice(0, d).map((name, j) => ({ group: "picked body: position", name, unit: "m", values: column(film.position, d, j) }));
    const names = d === 3 ? ["q_0", "q_1", "q_2", "q_3"] : ["angle"];
    return [...position, ...names.map((name, j) => ({ group: "picked body: turn", name, unit: d === 3 ? "" : "rad", values: column(film.turn, size, j) }))];
  }

  setFollowing(isFollowing) { this.isFollowing = isFollowing && (this.picked !== null || this.film.moving.radius > 0); $("follow").ariaPressed = this.isFollowing; }

  // The picked body in the middle; without one what moves, as near as it has room, or again all of the motion.
  follow(isFollowing) {
    this.setFollowing(isFollowing);
    if (this.picked === null) this.stage.fit(this.isFollowing ? this.film.moving.radius : null);
    this.show(this.frame);
  }

  pickNext(by) {
    const moving = this.film.bodies.flatMap((body, i) => (body.fixed ? [] : [i]));
    if (!moving.length) return;
    const at = moving.indexOf(this.picked);
    this.pick(moving[at < 0 ? (by > 0 ? 0 : moving.length - 1) : (at + by + moving.length) % moving.length]);
  }

  // --- words beside the scene

  write() {
    const { film } = this;
    $("title").textContent = film.title;
    $("outcome").textContent = film.about.outcome ?? "";
    $("about").replaceChildren(...Object.entries(film.about).flatMap(([name, value]) => [element("dt", { textContent: name }), element("dd", { textContent: value })]));
    $("detail").textContent = `Level of detail: ${film.detail}; ${CONTACT_DETAIL}; ${this.stage.detail}. No frame lies between two records.`;
    this.eventItems = film.marks.map((mark) => {
      const button = element("button", { textContent: `${timeText(film, mark.t)} s  ${mark.text}`, className: mark.isParadox ? "paradox" : "" });
      button.onclick = () => this.goTo(mark.frame);
      return button;
    });
    $("events").replaceChildren(...(film.marks.length ? this.eventItems.map((item) => element("li", {}, item)) : [element("li", { textContent: "none" })]));
    for (const id of ["before", "next"]) $(id).disabled = !film.marks.length;
  }

  writeLegend() {
    $("legend").replaceChildren(...legendOf(this.film, this.theme));
    $("legend").previousElementSibling.hidden = !$("legend").children.length;
  }

  tell() {
    const { film, frame } = this;
    $("clock").replaceChildren(`t = ${timeText(film, film.times[frame])} s `, element("small", { textContent: `frame ${frame + 1} of ${film.n}` }));
    if (this.isPlaying && this.drawn.length % 4) return; // the tables every fourth frame
    this.curves.forEach((curves) => curves.tell(frame, this.theme));
    $("body").replaceChildren(this.bodyTable());
    $("contacts").replaceChildren(...this.contactTable());
    const now = film.marks.findLastIndex((mark) => mark.frame <= frame);
    this.eventItems.forEach((item, i) => item.classList.toggle("now", i === now && film.marks[i].frame === frame));
    if (now >= 0) { const item = this.eventItems[now], list = $("events"); list.scrollTop = item.offsetTop - list.offsetTop - list.clientHeight / 2; }
    $("follow").disabled = this.picked === null && !film.moving.radius;
  }

  tellPlay() {
    $("play").textContent = this.isPlaying ? "⏸" : "▶";
    $("speed").textContent = `${short(this.speed)} × time`;
    if (!this.isPlaying) this.show(this.frame);
  }

  bodyTable() {
    if (this.picked === null) return element("p", { textContent: "none: click one, or press b", style: "margin:0;color:var(--faint)" });
    const d = this.film.dimension, position = this.positionOf(this.picked), turn = this.turnOf(this.picked);
    const rows = [
      ...position.map((value, j) => ["xyz"[j], figure(value, this.film.length), "m"]), ...turn.map((value, j) => [d === 3 ? `q_${j}` : "turned by", figure(value, 1), d === 3 ? "" : "rad"]),
      ...this.velocityOf(this.picked).map((value, j) => [`v_${"xyz"[j]}`, value, "m/s"]),
    ];
    const note = rows.length > d + turn.length ? "v: the mean since the frame before" : "";
    return element("div", {}, element("table", {}, element("caption", { textContent: this.film.bodies[this.picked].name, style: "text-align:left;font-weight:600" }),
      ...rows.map(([name, value, unit]) => element("tr", {}, element("td", { textContent: name }), element("td", { textContent: `${value} ${unit}` })))), element("small", { textContent: note }));
  }

  contactTable() {
    const { film } = this, all = this.contactsNow(), closed = all.filter((c) => film.contacts.mode[c] !== 0), unit = film.forces.kind(this.frame) === "force" ? "N" : "N s";
    if (!all.length) return [element("p", { textContent: "none", style: "margin:0;color:var(--faint)" })];
    const head = element("tr", {}, ...["", "mode", `normal [${unit.replace(" ", "\u00a0")}]`, `friction`].map((textContent) => element("th", { textContent })));
    const told = (all.length > TOLD ? this.strongest(closed) : all).map((c) => this.contact(c));
    const rows = told.map((c) => element("tr", {}, ...[`${c.number} ${c.name}`, c.mode, ...[c.normal, c.friction].map((value) => (c.mode === "open" && !c.P_N ? "" : figure(value, Math.abs(c.normal))))].map((textContent) => element("td", { textContent }))));
    const rest = closed.length > TOLD ? `the ${TOLD} strongest of ${closed.length} closed contacts` : all.length > TOLD ? `${closed.length} of ${all.length} closed` : "";
    return [element("table", {}, head, ...rows), element("p", { textContent: rest, style: "margin:0;color:var(--faint)" })];
  }

  // Those with the largest forces, as they are numbered.
  strongest(which) {
    const size = (c) => Math.hypot(...this.layer.vector(this.film.forces.vector, c));
    return which.map((c) => [size(c), c]).sort(([a], [b]) => b - a).slice(0, TOLD).map(([, c]) => c).sort((a, b) => a - b);
  }

  // The contacts of this frame, where they stand in the film.
  contactsNow() {
    const { start } = this.film.contacts, first = start[this.frame];
    return Array.from({ length: start[this.frame + 1] - first }, (_, i) => first + i);
  }

  // A contact: its mean force since the frame before, of an instant its impulse.
  contact(c) {
    const { contacts: all, forces, contactNames, modeOf } = this.film, [n, point, F] = [all.normal, all.point, forces.vector].map((values) => this.layer.vector(values, c));
    const normal = F.reduce((sum, value, j) => sum + value * n[j], 0);
    return { number: all.number[c], name: contactNames[all.number[c]] ?? "", mode: modeOf(c)[2], point, normal,
      friction: Math.hypot(...F.map((value, j) => value - normal * n[j])), P_N: all.P_N[c], mu: all.mu[c] };
  }

  // --- hands

  listen() {
    const act = {
      first: () => this.goTo(0), back: () => this.step(-1), play: () => (this.isPlaying ? this.pause() : this.play()), ahead: () => this.step(1),
      before: () => this.previousEvent(), next: () => this.nextEvent(), slower: () => this.changeSpeed(-1), faster: () => this.changeSpeed(1),
      fit: () => { this.setFollowing(false); this.stage.fit(); this.redraw(); }, follow: () => this.follow(!this.isFollowing),
      forces: () => { this.layer.hasForces = !this.layer.hasForces; $("forces").ariaPressed = this.layer.hasForces; this.redraw(); },
      save: () => this.save(), theme: () => this.setDark(!this.isDark), help: () => $("keys").showModal(),
    };
    for (const id in act) $(id).onclick = act[id];
    const keys = {
      " ": act.play, ArrowLeft: (e) => this.step(e.shiftKey ? -10 : -1), ArrowRight: (e) => this.step(e.shiftKey ? 10 : 1), p: act.before, n: act.next,
      Home: act.first, End: () => this.goTo(this.film.n - 1), "-": act.slower, "+": act.faster, b: () => this.pickNext(1), B: () => this.pickNext(-1),
      Escape: () => this.pick(null), l: act.follow, f: act.fit, c: act.forces, k: () => this.nextColours(), s: act.save, d: act.theme, h: act.help, "?": act.help,
    };
    addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || $("keys").open || event.target.tagName === "SELECT" || !keys[event.key]) return;
      event.preventDefault();
      keys[event.key](event);
    });
    $("forces").ariaPressed = this.layer.hasForces;
    $("follow").ariaPressed = false;
    $("colours").onchange = () => { this.setColours($("colours").value); $("colours").blur(); };
    gestures($("stage"), {
      drag: (dx, dy, isMove) => {
        if (isMove || this.film.dimension === 2) this.setFollowing(false);
        this.stage.drag(dx, dy, isMove);
        this.redraw();
      },
      zoom: (...how) => { this.stage.zoom(...how); this.redraw(); },
      tap: (x, y) => this.pick(this.stage.hit(x, y, this.frame)),
    });
    for (const chart of this.charts) this.scrubOn(chart);
    for (const curves of this.curves) curves.select.onchange = () => { curves.group = curves.select.value; curves.draw(this.theme); this.tell(); };
  }

  scrubOn(chart) {
    const scrub = (event) => { this.pause(); this.seek(chart.timeAt(event.clientX - chart.box.getBoundingClientRect().left)); };
    chart.canvas.onpointerdown = (event) => {
      const mark = chart.markNear?.(event.clientX - chart.box.getBoundingClientRect().left);
      if (mark) return this.goTo(mark.frame);
      chart.canvas.setPointerCapture(event.pointerId);
      scrub(event);
    };
    chart.canvas.onpointermove = (event) => {
      if (event.buttons && chart.canvas.hasPointerCapture(event.pointerId)) scrub(event);
      const mark = chart.markNear?.(event.clientX - chart.box.getBoundingClientRect().left);
      $("tip").hidden = !mark;
      if (!mark) return;
      $("tip").textContent = `t = ${timeText(this.film, mark.t)} s  ${mark.text}`;
      $("tip").style.cssText = `left:${Math.max(4, Math.min(event.clientX + 12, innerWidth - 330))}px;top:${event.clientY - 40}px`;
    };
    chart.canvas.onpointerleave = () => { $("tip").hidden = true; };
  }
}

function timeText(film, t) {
  const span = film.times[film.n - 1] - film.times[0] || 1;
  return t.toFixed(Math.min(9, Math.max(2, 4 - Math.floor(Math.log10(span)))));
}

// The colour, so much mixed with white that it is told from a dark ground.
function seenOn(colour, ground) {
  const [own, dark] = [colour, ground].map((text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16)));
  for (let share = 0; share < 1; share += 0.05) {
    const mixed = own.map((value) => Math.round(value + share * (255 - value)));
    if (contrast(mixed, dark) >= CONTRAST) return `#${mixed.map((value) => value.toString(16).padStart(2, "0")).join("")}`;
  }
  return "#ffffff";
}

// Of two colours, as WCAG 2 defines it: (L_1 + 0.05)/(L_0 + 0.05) with the relative luminances L.
function contrast(a, b) {
  const [L0, L1] = [a, b].map((colour) => colour.map((value) => (value / 255 <= 0.04045 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4)))
    .map(([r, g, s]) => 0.2126 * r + 0.7152 * g + 0.0722 * s).sort((x, y) => x - y);
  return (L1 + 0.05) / (L0 + 0.05);
}

function legendOf(film, theme) {
  const met = new Set();
  for (let c = 0; c < film.contacts.number.length; c++) met.add(film.modeOf(c));
  const item = (svg, text) => { const li = element("li"); li.innerHTML = `<svg viewBox="0 0 30 14">${svg}</svg>`; li.append(text); return li; };
  const modes = film.modes.filter((mode) => met.has(mode)).map(([code, , name, colour]) =>
    item(`<circle cx="15" cy="7" r="4.5" fill="${code ? colour : "none"}" stroke="${code ? "none" : "var(--still)"}"/>`, `contact: ${name}`));
  const kinds = new Set(film.marks.map((mark) => mark.kind)), marks = {
    impact: '<path d="M11.5 11h7l-3.5-8z" fill="var(--faint)"/>', "mode change": '<path d="M15 7v6" stroke="var(--faint)"/>',
    inconsistent: '<path d="M10 2h10l-5 10z" fill="var(--paradox)"/>', indeterminate: '<path d="M15 1v12" stroke="var(--paradox)" stroke-width="2"/>',
    "user event": '<path d="M12 4h6v6h-6z" fill="var(--faint)"/>',
  };
  const words = { inconsistent: "paradox: no solution; → mode after it", indeterminate: "paradox: several solutions; → the one taken" };
  const forces = met.size ? [
    item('<path d="M3 7h22m-6-4 6 4-6 4" fill="none" stroke="var(--ink)" stroke-width="2"/>', `${film.isOfLastStep ? "impulse of the last step on the body" : "force on the body, P/Δt since the frame before"}; two heads: larger than drawn${film.isOfLastStep ? "" : "; thick: an impulse"}`),
    ...(film.contacts.mu.some((mu) => mu > 0) ? [item('<path d="M15 13 6 1h18z" fill="var(--still)" fill-opacity=".3" stroke="var(--still)"/>', "friction cone |P_F| ≤ µ P_N")] : []),
  ] : [];
  const swatch = (colours, text) => item(colours.map((colour, i) => `<path d="M${9 + (12 * i) / colours.length} 2H21v10H${9 + (12 * i) / colours.length}z" fill="${colour}"/>`).join(""), text);
  const guided = film.bodies.some((body) => body.guided) ? [swatch(["rgb(var(--guided))"], "body that moves as it is told")] : [];
  return [...film.colouring.legend(theme).map((one) => swatch(...one)), ...modes, ...forces, ...guided, ...Object.keys(marks).filter((kind) => kinds.has(kind)).map((kind) => item(marks[kind], words[kind] ?? kind))];
}

// Drag with one pointer, pinch with two, wheel, and a tap that did not move.
function gestures(target, { drag, zoom, tap }) {
  const down = new Map();
  let moved = 0;
  const local = (event) => { const box = target.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
  target.addEventListener("pointerdown", (event) => { target.setPointerCapture(event.pointerId); if (!down.size) moved = 0; down.set(event.pointerId, local(event)); });
  target.addEventListener("pointermove", (event) => {
    const before = down.get(event.pointerId);
    if (!before) return;
    const now = local(event), other = [...down].find(([id]) => id !== event.pointerId)?.[1];
    moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
    down.set(event.pointerId, now);
    if (other) {
      const apart = (point) => Math.hypot(point[0] - other[0], point[1] - other[1]) || 1;
      zoom(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
      drag((now[0] - before[0]) / 2, (now[1] - before[1]) / 2, true);
    } else if (moved > 4) drag(now[0] - before[0], now[1] - before[1], event.shiftKey || event.buttons === 2);
  });
  const up = (event) => { if (down.delete(event.pointerId) && moved <= 4 && event.type === "pointerup" && !down.size) tap(...local(event)); };
  target.addEventListener("pointerup", up);
  target.addEventListener("pointercancel", up);
  target.addEventListener("contextmenu", (event) => event.preventDefault());
  target.addEventListener("wheel", (event) => { event.preventDefault(); zoom(Math.exp(-0.0015 * event.deltaY), ...local(event)); }, { passive: false });
}

function refuse(body) { throw new RangeError(`there is no body ${body}; see player.bodies`); }

async function start() {
  const film = await readFilm(JSON.parse($("film").textContent));
  const stage = film.dimension === 2 ? new Plane($("stage"), film) : await newSpace($("stage"), film);
  const player = new Player(film, stage);
  // what a script may use: docs/viewer.md
  window.player = {
    frames: film.n, times: film.times, bodies: film.bodies.map((body) => body.name), marks: film.marks,
    get frame() { return player.frame; }, get time() { return film.times[player.frame]; }, get isPlaying() { return player.isPlaying; },
    get speed() { return player.speed; }, set speed(speed) { player.speed = speed; player.tellPlay(); }, get rate() { return player.rate(); },
    play: () => player.play(), pause: () => player.pause(), seek: (t) => { player.pause(); player.seek(t); }, goTo: (frame) => player.goTo(frame),
    nextEvent: () => player.nextEvent(), previousEvent: () => player.previousEvent(), pick: (body) => player.pick(body === null || film.bodies[body] ? body : refuse(body)), get picked() { return player.picked; },
    body: (i) => ({ name: film.bodies[i].name, position: player.positionOf(i), turn: player.turnOf(i) }), contacts: () => player.contactsNow().map((c) => player.contact(c)),
    curves: () => film.curves.map(({ group, name, unit, values }) => ({ group, name, unit, value: values[player.frame] })),
    project: (point) => stage.project(point), setDark: (isDark) => player.setDark(isDark),
    colourings: film.colouring.choices, get colours() { return film.colouring.by; }, set colours(by) { player.setColours(by); },
    get isFollowing() { return player.isFollowing; }, follow: (isFollowing) => player.follow(isFollowing), picture: () => player.picture().toDataURL("image/png"),
  };
  document.documentElement.dataset.ready = "yes";
}

start().catch((error) => {
  $("message").hidden = false;
  $("message").textContent = `The player cannot start: ${error.message}`;
  document.documentElement.dataset.ready = "failed";
  throw error;
});
