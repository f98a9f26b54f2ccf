// A spatial film by three.js (https://threejs.org, MIT), which is unpacked from the page: z upwards.

const SHADES = ["#3f78b5", "#6d9fd0", "#2c5a8f"]; // chosen: of neighbouring bodies
const VIEW = 40; // chosen: degrees of the camera's angle
const FINE = 200; // chosen: shapes with corners: of more, spheres and capsules are coarse, edges are not smoothed
const FEWEST = 0.5; // chosen: share of the pixels along each side that a film is drawn with, where it would be too slow
const SHADE = [0.77, 0.23]; // chosen: of light and dark parts of a round body, their mean and how far they are from it
const ROOM = 0.88; // chosen: of the picture, what the box of the motion may fill
const SUN = [0.31, -0.54, 0.78]; // chosen: direction of the light
const LAND = 6; // chosen: of the size of the motion: the edge of the part of a half-space that is drawn

async function newSpace(canvas, film) {
  const source = await bytesOf(document.getElementById("three").textContent.trim());
  const three = await import(URL.createObjectURL(new Blob([source], { type: "text/javascript" })));
  try {
    return new Space(canvas, film, three);
  } catch (error) {
    throw new Error(`a spatial film needs WebGL, which this browser does not offer (${error.message})`);
  }
}

class Space {
  constructor(canvas, film, three) {
    Object.assign(this, { canvas, film, three, isCoarse: film.bodies.flatMap(({ shapes }) => shapes.filter(({ kind }) => kind !== "half-space")).length > FINE });
    three.ColorManagement.enabled = false; // colours as they are written: no power functions at each pixel
    this.renderer = new three.WebGLRenderer({ canvas, antialias: !this.isCoarse });
    this.renderer.outputColorSpace = three.LinearSRGBColorSpace;
    this.scene = new three.Scene();
    this.camera = new three.PerspectiveCamera(VIEW, 1);
    this.camera.up.set(0, 0, 1);
    [this.share, this.look] = [null, []];
    const faces = this.isCoarse ? `of more than ${FINE} shapes a sphere has 48 faces, a capsule 50` : "a sphere has 720 faces";
    this.detail = `${faces}; while it plays at fewer than ${FLUENT} pictures a second, fewer pixels, down to ${100 * FEWEST} % along each side`;
    this.measure();
    this.build();
    this.fit();
  }

  // Centre and radius of the motion.
  measure() {
    const { film } = this, n_b = film.bodies.length, low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const reach = film.bodies.map(({ shapes }) => Math.max(-1, ...shapes.filter(({ kind }) => kind !== "half-space").map((shape) => reachOf(shape, 3)))); // -1: is everywhere
    const areAllFixed = film.bodies.every(({ fixed }, b) => fixed || reach[b] < 0);
    for (let k = 0; k < film.n; k += Math.ceil(film.n / 100)) {
      for (let b = 0; b < n_b; b++) {
        if (reach[b] < 0 || (film.bodies[b].fixed && !areAllFixed)) continue;
        for (let j = 0; j < 3; j++) {
          const x = film.position[3 * (k * n_b + b) + j];
          low[j] = Math.min(low[j], x - reach[b]); high[j] = Math.max(high[j], x + reach[b]);
        }
      }
    }
    if (low[0] > high[0]) { low.fill(-1); high.fill(1); }
    this.middle = low.map((x, j) => (x + high[j]) / 2);
    this.corners = [...Array(8).keys()].map((i) => low.map((x, j) => (((i >> j) & 1) - 0.5) * (high[j] - x)));
    this.radius = Math.hypot(...low.map((x, j) => high[j] - x)) / 2 || 1;
    this.length = 2 * this.radius;
  }

  // Bodies of one form are one mesh, whose corners are moved and lit here: without a graphics card an instance costs as
  // much as a mesh, and light at each pixel more than the rest.
  build() {
    const forms = new Map();
    this.lines = [];
    this.film.bodies.forEach((body, b) => {
      for (const shape of body.shapes) {
        if (shape.kind === "half-space") this.addLand(b, shape);
        else if (shape.kind.endsWith("polyline")) this.addLine(b, shape);
        else {
          const key = ["capsule", "facets"].includes(shape.kind) ? `${shape.kind} ${shape.radius} ${shape.points}` : shape.kind;
          if (!forms.has(key)) forms.set(key, { shape, copies: [] });
          const isBall = shape.kind === "sphere", isBox = shape.kind === "box";
          forms.get(key).copies.push({ body: b, centre: isBall ? shape.points : shape.place?.slice(0, 3) ?? [0, 0, 0], turn: shape.place?.slice(3) ?? null, size: isBall ? Array(3).fill(shape.radius) : isBox ? shape.points : [1, 1, 1] });
        }
      }
    });
    this.meshes = [...forms.values()].map(({ shape, copies }) => this.addMesh(this.geometry(shape), copies));
  }

  addMesh(form, copies) {
    const { three } = this, [corners, normals] = ["position", "normal"].map((name) => form.getAttribute(name).array), m = corners.length;
    const geometry = new three.BufferGeometry(), faces = form.index.array;
    geometry.setIndex(new three.BufferAttribute(new Uint32Array(copies.length * faces.length), 1));
    for (const name of ["position", "color"]) geometry.setAttribute(name, new three.BufferAttribute(new Float32Array(copies.length * m), 3));
    const mesh = new three.Mesh(geometry, new three.MeshBasicMaterial({ vertexColors: true }));
    Object.assign(mesh, { copies, corners, normals, faces, planes: planesOf(corners, faces), shade: form.getAttribute("shade")?.array ?? new Float32Array(m / 3).fill(1), colours: new Float32Array(3 * copies.length), frustumCulled: false });
    this.scene.add(mesh);
    return mesh;
  }

  geometry({ kind, points, radius, shade }) {
    const { three } = this;
    if (kind === "box") return new three.BoxGeometry(2, 2, 2);
    if (kind === "facets") {
      const form = new three.BufferGeometry().setAttribute("position", new three.BufferAttribute(points, 3));
      form.setIndex([...Array(points.length / 3).keys()]);
      form.computeVertexNormals();
      if (shade) form.setAttribute("shade", new three.BufferAttribute(Float32Array.from({ length: points.length / 3 }, (_, i) => SHADE[0] + SHADE[1] * shade[Math.floor(i / 3)]), 1));
      return form;
    }
    if (kind === "capsule") {
      const [a, b] = [new three.Vector3(...points.subarray(0, 3)), new three.Vector3(...points.subarray(3, 6))], axis = b.clone().sub(a);
      const form = new three.CapsuleGeometry(radius, axis.length(), this.isCoarse ? 1 : 6, this.isCoarse ? 5 : 20);
      form.applyQuaternion(new three.Quaternion().setFromUnitVectors(new three.Vector3(0, 1, 0), axis.normalize()));
      return form.translate(...a.add(b).multiplyScalar(0.5).toArray());
    }
    const ball = this.isCoarse ? new three.SphereGeometry(1, 8, 4) : new three.SphereGeometry(1, 24, 16), where = ball.getAttribute("position");
    const sign = (x) => (x < -1e-6 ? -1 : 1); // eighths, light and dark, by which rolling is seen
    const eighths = Float32Array.from({ length: where.count }, (_, i) => SHADE[0] + SHADE[1] * sign(where.getX(i)) * sign(where.getY(i)) * sign(where.getZ(i)));
    return ball.setAttribute("shade", new three.BufferAttribute(eighths, 1));
  }

  addLand(body, shape) {
    const { three, radius } = this, near = this.film.moving.isLostIn(2 * radius) ? Math.max(this.film.moving.radius, radius / 10) : radius;
    const size = LAND * near + 2 * (radius - near), step = roundUp(near / 6), n = Math.ceil(size / step / 2) * 2;
    const land = new three.Group(), grid = new three.GridHelper(n * step, n);
    const ground = new three.Mesh(new three.PlaneGeometry(n * step, n * step), new three.MeshBasicMaterial({ polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2 }));
    grid.geometry.rotateX(Math.PI / 2);
    grid.geometry.deleteAttribute("color");
    grid.material = new three.LineBasicMaterial({ transparent: this.film.bodies[body].guided, opacity: this.film.bodies[body].guided ? 0.5 : 1 });
    land.add(ground, grid);
    const [u, v, s, q_0, q_1, q_2, q_3] = shape.place ?? [0, 0, 0, 1, 0, 0, 0], holder = new three.Group();
    land.position.set(u, v, s);
    land.quaternion.set(q_1, q_2, q_3, q_0);
    holder.add(land);
    this.scene.add(holder);
    this.lines.push({ body, object: holder, land });
    this.gridStep = step;
  }

  addLine(body, shape) {
    const { three } = this, geometry = new three.BufferGeometry(), m = shape.size[shape.size.length - 2];
    geometry.setAttribute("position", new three.BufferAttribute(shape.points.slice(0, 3 * m), 3));
    const line = new three.Line(geometry, new three.LineBasicMaterial());
    line.frustumCulled = false;
    this.scene.add(line);
    this.lines.push({ body, object: line, bending: shape.size.length === 3 ? shape.points : null });
  }

  // --- the camera: around a target at angles, at a distance

  // All of the motion in view, or a ball of so much around what is in its middle.
  fit(near = null) {
    Object.assign(this, { near, isFitted: true });
    if (near) { this.distance = near / Math.sin(Math.atan(ROOM * Math.tan((VIEW * Math.PI) / 360) * Math.min(1, this.camera.aspect))); return; }
    Object.assign(this, { target: [...this.middle], azimuth: -0.9, height: 0.35 });
    this.distance = Math.max(...this.corners.map((corner) => this.distanceFor(corner)));
  }

  // From where a corner of the box of the motion is just in the picture.
  distanceFor(corner) {
    const out = this.outwards(), right = [-Math.sin(this.azimuth), Math.cos(this.azimuth), 0], along = (v) => corner.reduce((sum, x, j) => sum + x * v[j], 0);
    const up = [out[1] * right[2] - out[2] * right[1], out[2] * right[0] - out[0] * right[2], out[0] * right[1] - out[1] * right[0]];
    const wide = ROOM * Math.tan((VIEW * Math.PI) / 360);
    return along(out) + Math.max(Math.abs(along(up)), Math.abs(along(right)) / this.camera.aspect) / wide;
  }

  outwards() { return [Math.cos(this.height) * Math.cos(this.azimuth), Math.cos(this.height) * Math.sin(this.azimuth), Math.sin(this.height)]; }

  resize(width, height, ratio) {
    [this.width, this.height_px] = [width, height];
    this.ratio = ratio;
    this.setPixels(this.share);
    this.camera.aspect = width / height;
    if (this.isFitted) this.fit(this.near);
  }

  // While it plays, a share of the picture's pixels along each side; where it stands all of them, of many shapes two for one.
  setPixels(share = null) {
    const full = Math.min(this.ratio, 2);
    this.renderer.setPixelRatio(this.isCoarse ? share ?? Math.max(full, 2) : (share ?? 1) * full);
    this.renderer.setSize(this.width, this.height_px, false);
    this.share = share;
  }

  begin() { this.setPixels(1); }
  hurry() { if (this.share > FEWEST) this.setPixels(Math.max(FEWEST, this.share / Math.SQRT2)); }
  stand() { this.setPixels(); }

  aim() {
    const { camera, distance } = this, out = this.outwards();
    camera.position.set(...this.target.map((x, j) => x + distance * out[j]));
    camera.lookAt(...this.target);
    camera.near = distance / 100; camera.far = 100 * distance + 20 * this.radius;
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    this.view = new this.three.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse).elements; // by columns
  }

  get unit() { return (2 * this.distance * Math.tan((VIEW * Math.PI) / 360)) / this.height_px; } // of length, per pixel at the target

  project([x, y, z]) {
    const e = this.view, w = e[3] * x + e[7] * y + e[11] * z + e[15];
    if (!(w > 0)) return [NaN, NaN]; // behind the camera
    const across = (e[0] * x + e[4] * y + e[8] * z + e[12]) / w, up = (e[1] * x + e[5] * y + e[9] * z + e[13]) / w;
    return [(this.width * (1 + across)) / 2, (this.height_px * (1 - up)) / 2];
  }

  drag(dx, dy, isMove) {
    this.isFitted = false;
    if (!isMove) {
      this.azimuth -= 0.008 * dx;
      this.height = Math.min(1.55, Math.max(-1.55, this.height + 0.008 * dy));
      return;
    }
    const e = this.camera.matrixWorld.elements; // its columns: right, up, backwards
    this.target = this.target.map((x, j) => x - this.unit * (dx * e[j] - dy * e[4 + j]));
  }

  zoom(factor) { this.distance /= factor; this.isFitted = false; }
  centre(point) { this.target = point; this.isFitted &&= this.near !== null; }

  // --- drawing

  draw(k, picked, theme) {
    const { by } = this.film.colouring, look = [theme, picked, by, by === "speed" && k];
    if (look.some((one, i) => one !== this.look[i])) this.paint(k, picked, theme);
    this.look = look;
    this.aim();
    for (const mesh of this.meshes) this.place(mesh, k);
    const lands = [];
    for (const { body, object, land, bending } of this.lines) {
      const at = k * this.film.bodies.length + body, [w, x, y, z] = this.film.turn.subarray(4 * at, 4 * at + 4);
      object.position.set(...this.film.position.subarray(3 * at, 3 * at + 3));
      object.quaternion.set(x, y, z, w);
      if (land) lands.push(land);
      if (!bending) continue;
      const where = object.geometry.getAttribute("position"), size = where.array.length;
      where.array.set(bending.subarray(k * size, (k + 1) * size));
      where.needsUpdate = true;
    }
    for (const land of lands) land.visible = land.worldToLocal(this.camera.position.clone()).z > 0; // from within nothing is seen of it
    this.renderer.render(this.scene, this.camera);
  }

  // The corners of all copies of a form, and those of its faces that are seen.
  place(mesh, k) {
    const index = mesh.geometry.index, attributes = ["position", "color"].map((name) => mesh.geometry.getAttribute(name));
    let n = 0;
    mesh.copies.forEach((copy, i) => {
      const pose = this.poseOf(copy, k);
      this.move(mesh, i, pose);
      n = this.takeFaces(mesh, i, pose, n);
    });
    mesh.geometry.setDrawRange(0, n);
    index.clearUpdateRanges();
    index.addUpdateRange(0, n);
    for (const attribute of [index, ...attributes]) attribute.needsUpdate = true;
  }

  // Place of the centre, and rotation by rows.
  poseOf({ body, centre, turn: own }, k) {
    const { position, turn, bodies } = this.film, at = k * bodies.length + body, whole = turn.subarray(4 * at, 4 * at + 4);
    const [ox, oy, oz] = turned(whole, centre), [w, x, y, z] = own ? times(whole, own) : whole;
    return [
      position[3 * at] + ox, position[3 * at + 1] + oy, position[3 * at + 2] + oz,
      1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
    ];
  }

  // Rotation times size, and the place of the centre; lighter towards the sun.
  move({ corners, normals, shade, colours, copies, geometry }, i, [px, py, pz, xx, xy, xz, yx, yy, yz, zx, zy, zz]) {
    const X = geometry.getAttribute("position").array, C = geometry.getAttribute("color").array, m = corners.length, [a, b, c] = copies[i].size;
    const lx = xx * SUN[0] + yx * SUN[1] + zx * SUN[2], ly = xy * SUN[0] + yy * SUN[1] + zy * SUN[2], lz = xz * SUN[0] + yz * SUN[1] + zz * SUN[2];
    for (let j = 0, o = i * m; j < m; j += 3, o += 3) {
      const u = a * corners[j], v = b * corners[j + 1], s = c * corners[j + 2];
      X[o] = px + xx * u + xy * v + xz * s; X[o + 1] = py + yx * u + yy * v + yz * s; X[o + 2] = pz + zx * u + zy * v + zz * s;
      const light = shade[j / 3] * (0.85 + 0.35 * (normals[j] * lx + normals[j + 1] * ly + normals[j + 2] * lz));
      C[o] = light * colours[3 * i]; C[o + 1] = light * colours[3 * i + 1]; C[o + 2] = light * colours[3 * i + 2];
    }
  }

  // Appends the faces whose plane has the eye in front of it: the others are never seen, and without a graphics card a
  // face costs half a microsecond. The eye is taken to the form, where the planes stay as they are.
  takeFaces({ corners, faces, planes, copies, geometry }, i, [px, py, pz, xx, xy, xz, yx, yy, yz, zx, zy, zz], n) {
    const all = geometry.index.array, first = (i * corners.length) / 3, [a, b, c] = copies[i].size, eye = this.camera.position;
    const x = eye.x - px, y = eye.y - py, z = eye.z - pz;
    const u = (xx * x + yx * y + zx * z) / a, v = (xy * x + yy * y + zy * z) / b, s = (xz * x + yz * y + zz * z) / c;
    for (let f = 0, o = 0; f < planes.length; f += 4, o += 3) {
      if (!(planes[f] * u + planes[f + 1] * v + planes[f + 2] * s > planes[f + 3])) continue;
      all[n] = first + faces[o]; all[n + 1] = first + faces[o + 1]; all[n + 2] = first + faces[o + 2];
      n += 3;
    }
    return n;
  }

  paint(k, picked, theme) {
    const colour = new this.three.Color();
    this.renderer.setClearColor(theme.ground);
    for (const mesh of this.meshes) {
      mesh.copies.forEach(({ body }, i) => {
        colour.set(this.colourOf(body, k, picked, theme));
        colour.toArray(mesh.colours, 3 * i);
      });
    }
    for (const { body, object, land } of this.lines) {
      if (land) {
        land.children[0].material.color.set(theme.panel);
        land.children[1].material.color.set(this.film.bodies[body].guided ? `rgb(${theme.guided})` : theme.line);
      } else object.material.color.set(this.colourOf(body, k, picked, theme));
    }
  }

  colourOf(body, k, picked, theme) {
    const { fixed, guided } = this.film.bodies[body];
    if (body === picked) return theme.picked;
    return fixed ? theme.still : guided ? `rgb(${theme.guided})` : this.film.colouring.of(body, k, theme) ?? SHADES[body % SHADES.length];
  }

  hit(px, py) {
    const ray = new this.three.Raycaster();
    ray.setFromCamera(new this.three.Vector2((2 * px) / this.width - 1, 1 - (2 * py) / this.height_px), this.camera);
    for (const mesh of this.meshes) mesh.geometry.boundingSphere = null; // of another frame
    const found = ray.intersectObjects(this.meshes).map(({ object, face }) => object.copies[Math.floor((3 * face.a) / object.corners.length)].body);
    return found.find((body) => !this.film.bodies[body].fixed) ?? null;
  }

  scaleText() { return this.gridStep ? `grid ${short(this.gridStep)} m` : ""; }
}

// Of each face its normal and how far its plane is from the origin, times twice its area: all 0 where it has none.
function planesOf(corners, faces) {
  const planes = new Float64Array((4 * faces.length) / 3);
  for (let f = 0; f < faces.length; f += 3) {
    const [A, B, C] = [0, 1, 2].map((j) => corners.subarray(3 * faces[f + j], 3 * faces[f + j] + 3)), [p, q] = [B, C].map((X) => X.map((x, j) => x - A[j]));
    const n = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    planes.set([...n, n[0] * A[0] + n[1] * A[1] + n[2] * A[2]], (4 * f) / 3);
  }
  return planes;
}

// Quaternions, the real part first: first the turn b, then a; and a vector turned by one.
function times([a, b, c, d], [e, f, g, h]) {
  return [a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g, a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e];
}

function turned(q, v) {
  if (!v[0] && !v[1] && !v[2]) return v;
  return times(times(q, [0, ...v]), [q[0], -q[1], -q[2], -q[3]]).slice(1);
}
