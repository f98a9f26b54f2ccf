// A spatial film by three.js (https://threejs.org, MIT), which is unpacked from the page: z upwards.

const SHADES = ["#3f78b5", "#6d9fd0", "#2c5a8f"]; // chosen: of neighbouring bodies
const VIEW = 40; // chosen: degrees of the camera's angle
const FINE = 200; // chosen: bodies: of more, spheres and capsules are coarse, edges are not smoothed
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
    Object.assign(this, { canvas, film, three, isCoarse: film.bodies.length > FINE });
    three.ColorManagement.enabled = false; // colours as they are written: no power functions at each pixel
    this.renderer = new three.WebGLRenderer({ canvas, antialias: !this.isCoarse });
    this.renderer.outputColorSpace = three.LinearSRGBColorSpace;
    this.scene = new three.Scene();
    this.camera = new three.PerspectiveCamera(VIEW, 1);
    this.camera.up.set(0, 0, 1);
    this.detail = this.isCoarse ? `of more than ${FINE} bodies a sphere has 48 faces, a capsule 50` : "a sphere has 720 faces";
    this.measure();
    this.build();
    this.fit();
  }

  // Centre and radius of the motion.
  measure() {
    const { film } = this, n_b = film.bodies.length, low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const reach = film.bodies.map(({ shapes }) => Math.max(0, ...shapes.map(({ points, radius }) => radius + Math.hypot(...points.subarray(0, 3)))));
    const areAllFixed = film.bodies.every(({ fixed }) => fixed);
    for (let k = 0; k < film.n; k += Math.ceil(film.n / 100)) {
      for (let b = 0; b < n_b; b++) {
        if (film.bodies[b].fixed && !areAllFixed) continue;
        for (let j = 0; j < 3; j++) {
          const x = film.position[3 * (k * n_b + b) + j];
          low[j] = Math.min(low[j], x - reach[b]); high[j] = Math.max(high[j], x + reach[b]);
        }
      }
    }
    this.middle = low.map((x, j) => (x + high[j]) / 2);
    this.radius = Math.hypot(...low.map((x, j) => high[j] - x)) / 2 || 1;
  }

  // Bodies of one form are one mesh, whose corners are moved and lit here: without a graphics card an instance costs as
  // much as a mesh, and light at each pixel more than the rest.
  build() {
    const forms = new Map();
    this.lines = [];
    this.film.bodies.forEach((body, b) => {
      for (const shape of body.shapes) {
        if (shape.kind === "half-space") this.addLand(b);
        else if (shape.kind.endsWith("polyline")) this.addLine(b, shape);
        else {
          const key = shape.kind === "capsule" ? `capsule ${shape.radius} ${shape.points}` : shape.kind;
          if (!forms.has(key)) forms.set(key, { shape, copies: [] });
          const isBall = shape.kind === "sphere", isBox = shape.kind === "box";
          forms.get(key).copies.push({ body: b, centre: isBall ? shape.points : [0, 0, 0], size: isBall ? Array(3).fill(shape.radius) : isBox ? shape.points : [1, 1, 1] });
        }
      }
    });
    this.meshes = [...forms.values()].map(({ shape, copies }) => this.addMesh(this.geometry(shape), copies));
  }

  addMesh(form, copies) {
    const { three } = this, [corners, normals] = ["position", "normal"].map((name) => form.getAttribute(name).array), m = corners.length;
    const geometry = new three.BufferGeometry(), faces = form.index.array, all = new Uint32Array(copies.length * faces.length);
    copies.forEach((_, i) => faces.forEach((corner, j) => { all[i * faces.length + j] = (i * m) / 3 + corner; }));
    geometry.setIndex(new three.BufferAttribute(all, 1));
    for (const name of ["position", "color"]) geometry.setAttribute(name, new three.BufferAttribute(new Float32Array(copies.length * m), 3));
    const mesh = new three.Mesh(geometry, new three.MeshBasicMaterial({ vertexColors: true }));
    Object.assign(mesh, { copies, corners, normals, shade: form.getAttribute("shade")?.array ?? new Float32Array(m / 3).fill(1), colours: new Float32Array(3 * copies.length), facesOfOne: faces.length / 3, frustumCulled: false });
    this.scene.add(mesh);
    return mesh;
  }

  geometry({ kind, points, radius }) {
    const { three } = this;
    if (kind === "box") return new three.BoxGeometry(2, 2, 2);
    if (kind === "capsule") {
      const [a, b] = [new three.Vector3(...points.subarray(0, 3)), new three.Vector3(...points.subarray(3, 6))], axis = b.clone().sub(a);
      const form = new three.CapsuleGeometry(radius, axis.length(), this.isCoarse ? 1 : 6, this.isCoarse ? 5 : 20);
      form.applyQuaternion(new three.Quaternion().setFromUnitVectors(new three.Vector3(0, 1, 0), axis.normalize()));
      return form.translate(...a.add(b).multiplyScalar(0.5).toArray());
    }
    const ball = this.isCoarse ? new three.SphereGeometry(1, 8, 4) : new three.SphereGeometry(1, 24, 16), where = ball.getAttribute("position");
    const sign = (x) => (Math.abs(x) < 1e-6 ? 0 : Math.sign(x)); // eighths, light and dark, by which rolling is seen
    const shade = Float32Array.from({ length: where.count }, (_, i) => 0.86 + 0.14 * sign(where.getX(i)) * sign(where.getY(i)) * sign(where.getZ(i)));
    return ball.setAttribute("shade", new three.BufferAttribute(shade, 1));
  }

  addLand(body) {
    const { three } = this, size = LAND * this.radius, step = roundUp(this.radius / 6), n = Math.ceil(size / step / 2) * 2;
    const land = new three.Group(), grid = new three.GridHelper(n * step, n);
    const ground = new three.Mesh(new three.PlaneGeometry(n * step, n * step), new three.MeshBasicMaterial({ polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2 }));
    grid.geometry.rotateX(Math.PI / 2);
    grid.geometry.deleteAttribute("color");
    grid.material = new three.LineBasicMaterial();
    land.add(ground, grid);
    this.scene.add(land);
    this.lines.push({ body, object: land, isLand: true });
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

  fit() {
    Object.assign(this, { target: [...this.middle], azimuth: -0.9, height: 0.35, distance: (0.9 * this.radius) / Math.sin((VIEW * Math.PI) / 360) });
  }

  resize(width, height, ratio) {
    [this.width, this.height_px] = [width, height];
    this.renderer.setPixelRatio(this.isCoarse ? 1 : Math.min(ratio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
  }

  aim() {
    const { camera, distance } = this, out = [Math.cos(this.height) * Math.cos(this.azimuth), Math.cos(this.height) * Math.sin(this.azimuth), Math.sin(this.height)];
    camera.position.set(...this.target.map((x, j) => x + distance * out[j]));
    camera.lookAt(...this.target);
    camera.near = distance / 100; camera.far = 100 * distance + 20 * this.radius;
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }

  get unit() { return (2 * this.distance * Math.tan((VIEW * Math.PI) / 360)) / this.height_px; } // of length, per pixel at the target

  project(point) {
    const { x, y, z } = new this.three.Vector3(...point).project(this.camera);
    return z > 1 ? [NaN, NaN] : [(this.width * (1 + x)) / 2, (this.height_px * (1 - y)) / 2];
  }

  drag(dx, dy, isMove) {
    if (!isMove) {
      this.azimuth -= 0.008 * dx;
      this.height = Math.min(1.55, Math.max(-1.55, this.height + 0.008 * dy));
      return;
    }
    const e = this.camera.matrixWorld.elements; // its columns: right, up, backwards
    this.target = this.target.map((x, j) => x - this.unit * (dx * e[j] - dy * e[4 + j]));
  }

  zoom(factor) { this.distance /= factor; }
  centre(point) { this.target = point; }

  // --- drawing

  draw(k, picked, theme) {
    if (this.painted !== theme || this.pickedLast !== picked) this.paint(picked, theme);
    for (const mesh of this.meshes) this.place(mesh, k);
    for (const { body, object, bending } of this.lines) {
      const at = k * this.film.bodies.length + body, [w, x, y, z] = this.film.turn.subarray(4 * at, 4 * at + 4);
      object.position.set(...this.film.position.subarray(3 * at, 3 * at + 3));
      object.quaternion.set(x, y, z, w);
      if (!bending) continue;
      const where = object.geometry.getAttribute("position"), size = where.array.length;
      where.array.set(bending.subarray(k * size, (k + 1) * size));
      where.needsUpdate = true;
    }
    this.aim();
    this.renderer.render(this.scene, this.camera);
  }

  // The corners of all copies of a form: rotation times size, and the place of the centre; lighter towards the sun.
  place(mesh, k) {
    const { position, turn, bodies } = this.film, { corners, normals, shade, colours, copies } = mesh, m = corners.length;
    const moved = mesh.geometry.getAttribute("position"), lit = mesh.geometry.getAttribute("color"), X = moved.array, C = lit.array;
    copies.forEach(({ body, centre: [cx, cy, cz], size: [a, b, c] }, i) => {
      const at = k * bodies.length + body, w = turn[4 * at], x = turn[4 * at + 1], y = turn[4 * at + 2], z = turn[4 * at + 3];
      const xx = 1 - 2 * (y * y + z * z), xy = 2 * (x * y - w * z), xz = 2 * (x * z + w * y);
      const yx = 2 * (x * y + w * z), yy = 1 - 2 * (x * x + z * z), yz = 2 * (y * z - w * x);
      const zx = 2 * (x * z - w * y), zy = 2 * (y * z + w * x), zz = 1 - 2 * (x * x + y * y);
      const lx = xx * SUN[0] + yx * SUN[1] + zx * SUN[2], ly = xy * SUN[0] + yy * SUN[1] + zy * SUN[2], lz = xz * SUN[0] + yz * SUN[1] + zz * SUN[2];
      const px = position[3 * at], py = position[3 * at + 1], pz = position[3 * at + 2];
      for (let j = 0, o = i * m; j < m; j += 3, o += 3) {
        const u = cx + a * corners[j], v = cy + b * corners[j + 1], s = cz + c * corners[j + 2];
        X[o] = px + xx * u + xy * v + xz * s; X[o + 1] = py + yx * u + yy * v + yz * s; X[o + 2] = pz + zx * u + zy * v + zz * s;
        const light = shade[j / 3] * (0.85 + 0.35 * (normals[j] * lx + normals[j + 1] * ly + normals[j + 2] * lz));
        C[o] = light * colours[3 * i]; C[o + 1] = light * colours[3 * i + 1]; C[o + 2] = light * colours[3 * i + 2];
      }
    });
    moved.needsUpdate = lit.needsUpdate = true;
  }

  paint(picked, theme) {
    const colour = new this.three.Color();
    this.renderer.setClearColor(theme.ground);
    for (const mesh of this.meshes) {
      mesh.copies.forEach(({ body }, i) => {
        colour.set(body === picked ? theme.picked : this.film.bodies[body].fixed ? theme.still : SHADES[body % SHADES.length]);
        colour.toArray(mesh.colours, 3 * i);
      });
    }
    for (const { body, object, isLand } of this.lines) {
      if (isLand) { object.children[0].material.color.set(theme.panel); object.children[1].material.color.set(theme.line); }
      else object.material.color.set(body === picked ? theme.picked : this.film.bodies[body].fixed ? theme.still : SHADES[0]);
    }
    [this.painted, this.pickedLast] = [theme, picked];
  }

  hit(px, py) {
    const ray = new this.three.Raycaster();
    ray.setFromCamera(new this.three.Vector2((2 * px) / this.width - 1, 1 - (2 * py) / this.height_px), this.camera);
    for (const mesh of this.meshes) mesh.geometry.boundingSphere = null; // of another frame
    const found = ray.intersectObjects(this.meshes).map(({ object, faceIndex }) => object.copies[Math.floor(faceIndex / object.facesOfOne)].body);
    return found.find((body) => !this.film.bodies[body].fixed) ?? null;
  }

  scaleText() { return this.gridStep ? `grid ${short(this.gridStep)} m` : ""; }
}
