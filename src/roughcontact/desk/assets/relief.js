// Heights of a map in 3-D, colored by a second map; on one canvas of WebGL2 and one for the axes.
// One unit of the scene is half of the longer side of the map; z is up, and y is that of the maps,
// which points away from the one who looks at them from above.

const GONE = -1e29; // Below: a cell whose points are missing.

const VERTEX = `#version 300 es
precision highp float; precision highp int; precision highp sampler2D;
uniform sampler2D heights; uniform ivec2 count; uniform vec2 cell; uniform vec2 lift;
uniform mat4 camera;
out vec3 normal; out vec3 place; out vec2 cellAt; out float gone;
float at(ivec2 p) {
  float h = texelFetch(heights, clamp(p, ivec2(0), count - 1), 0).r;
  return h < ${GONE.toExponential()} ? 0. : (h - lift.x) * lift.y;
}
void main() {
  ivec2 p = ivec2(gl_VertexID % count.x, gl_VertexID / count.x);
  vec2 middle = (vec2(p) + .5 - vec2(count) / 2.) * cell;
  place = vec3(middle.x, -middle.y, at(p));
  gone = texelFetch(heights, p, 0).r < ${GONE.toExponential()} ? 1. : 0.;
  cellAt = vec2(p) + .5;
  normal = vec3((at(p - ivec2(1, 0)) - at(p + ivec2(1, 0))) / (2. * cell.x),
                (at(p + ivec2(0, 1)) - at(p - ivec2(0, 1))) / (2. * cell.y), 1.);
  gl_Position = camera * vec4(place, 1.);
}`;

const FRAGMENT = `#version 300 es
precision highp float; precision highp int; precision highp sampler2D;
uniform sampler2D colors, palette; uniform ivec2 count; uniform vec3 eye;
in vec3 normal; in vec3 place; in vec2 cellAt; in float gone; out vec4 color;
void main() {
  if (gone > 0.) discard;
  float level = texelFetch(colors, min(ivec2(cellAt), count - 1), 0).r;
  vec3 own = texelFetch(palette, ivec2(level * 255. + .5, 0), 0).rgb;
  vec3 n = normalize(normal), e = normalize(eye - place);
  if (dot(n, e) < 0.) n = -n;
  vec3 light = vec3(-.56, .52, .65);
  float lit = max(dot(n, light), 0.), shine = pow(max(dot(reflect(-light, n), e), 0.), 24.);
  color = vec4(own * (.4 + .6 * lit) + .12 * shine, 1.);
}`;

const START = { yaw: -1.05, pitch: 0.6, distance: 3.8 };
const HALF_ANGLE = 0.35; // Of what the camera sees, up and down.

function program(gl) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
      throw Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw Error(gl.getProgramInfoLog(made));
  return made;
}

// The surface alone, on a canvas that is transparent elsewhere; null without WebGL2.
function surface(canvas) {
  const gl = canvas.getContext("webgl2", { antialias: true });
  if (gl == null) return null;
  const made = program(gl);
  gl.useProgram(made);
  const place = (name) => gl.getUniformLocation(made, name);
  const names = ["heights", "colors", "palette"];
  const textures = names.map((name, unit) => {
    gl.uniform1i(place(name), unit);
    gl.activeTexture(gl.TEXTURE0 + unit);
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const way of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
      gl.texParameteri(gl.TEXTURE_2D, way, gl.NEAREST);
    for (const way of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
      gl.texParameteri(gl.TEXTURE_2D, way, gl.CLAMP_TO_EDGE);
    return texture;
  });
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.enable(gl.DEPTH_TEST);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  let corners = 0;
  const put = (unit, inside, width, height, format, kind, data) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, textures[unit]);
    gl.texImage2D(gl.TEXTURE_2D, 0, inside, width, height, 0, format, kind, data);
  };
  return {
    heights(values, nx, ny) {
      put(0, gl.R32F, nx, ny, gl.RED, gl.FLOAT, values);
      gl.uniform2i(place("count"), nx, ny);
      const index = new Uint32Array(6 * (nx - 1) * (ny - 1));
      let n = 0;
      for (let y = 0; y < ny - 1; y++)
        for (let x = 0; x < nx - 1; x++) {
          const i = y * nx + x;
          index.set([i, i + 1, i + nx, i + 1, i + nx + 1, i + nx], n);
          n += 6;
        }
      corners = n;
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, index, gl.STATIC_DRAW);
    },
    colors(levels, nx, ny) { put(1, gl.R8, nx, ny, gl.RED, gl.UNSIGNED_BYTE, levels); },
    palette(rgba) { put(2, gl.RGBA8, 256, 1, gl.RGBA, gl.UNSIGNED_BYTE, rgba); },
    draw(camera, eye, cell, lift) {
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.uniformMatrix4fv(place("camera"), false, camera);
      gl.uniform3fv(place("eye"), eye);
      gl.uniform2fv(place("cell"), cell);
      gl.uniform2fv(place("lift"), lift);
      gl.drawElements(gl.TRIANGLES, corners, gl.UNSIGNED_INT, 0);
    },
    end() { gl.getExtension("WEBGL_lose_context")?.loseContext(); },
  };
}

// Columns of the product of two matrices of four columns each.
function product(a, b) {
  const result = new Float32Array(16);
  for (let i = 0; i < 4; i++)
    for (let j = 0; j < 4; j++)
      for (let k = 0; k < 4; k++) result[4 * i + j] += a[4 * k + j] * b[4 * i + k];
  return result;
}

function camera({ yaw, pitch, distance }, aspect) {
  const [cp, sp, cy, sy] = [Math.cos(pitch), Math.sin(pitch), Math.cos(yaw), Math.sin(yaw)];
  const view = new Float32Array([
    -sy, -sp * cy, cp * cy, 0, cy, -sp * sy, cp * sy, 0, 0, cp, sp, 0, 0, 0, -distance, 1,
  ]);
  const q = 1 / Math.tan(HALF_ANGLE), near = 0.05, far = 50;
  const lens = new Float32Array([
    q / aspect, 0, 0, 0, 0, q, 0, 0, 0, 0, (far + near) / (near - far), -1,
    0, 0, (2 * far * near) / (near - far), 0,
  ]);
  const eye = [distance * cp * cy, distance * cp * sy, distance * sp];
  return { matrix: product(lens, view), eye };
}

// The nearest of 1, 2, 5, 10, 20, ... below a number.
function round(value) {
  const power = 10 ** Math.floor(Math.log10(value) + 1e-9);
  const first = value / power + 1e-9;
  return (first >= 5 ? 5 : first >= 2 ? 2 : 1) * power;
}

const number = (value) => `${Number(value.toPrecision(4))}`.replace("-", "\u2212");

export function render({ model, el }) {
  const area = document.createElement("div");
  area.className = "relief";
  const scene = document.createElement("div");
  scene.className = "scene";
  scene.tabIndex = 0;
  scene.setAttribute("role", "img");
  const [under, over] = [0, 1].map(() => document.createElement("canvas"));
  scene.append(under, over);
  const below = document.createElement("div");
  below.className = "below";
  area.append(scene, below);

  const drawn = surface(over);
  if (drawn == null) {
    area.textContent = "This browser has no WebGL2, which the 3-D view needs. "
      + "The maps show the same values.";
    return area;
  }

  const control = (name, min, max) => {
    const label = document.createElement("label");
    const input = document.createElement("input");
    const text = document.createElement("output");
    Object.assign(input, { type: "range", min, max, value: 0 });
    label.append(name, input, text);
    below.append(label);
    return [input, text];
  };

  let map = null, shown = null, look = { ...START }, waits = 0;
  const [height, factorText] = control("Height scale", -5, 5);
  const note = document.createElement("p");
  below.append(note);

  const factor = () => {
    let result = map.factor;
    for (let n = Math.abs(height.valueAsNumber); n > 0; n--)
      result = height.valueAsNumber > 0 ? round(result * 2.5) : round(result / 2 + 1e-12 * result);
    return result;
  };

  // A place [m] in the scene: along x and y from the corner of the map, and its height.
  const inScene = (x, y, z) => {
    const [ly, lx] = map.side, unit = Math.max(ly, lx) / 2;
    const middle = (map.low + map.high) / 2;
    return [(x - lx / 2) / unit, -(y - ly / 2) / unit, ((z - middle) * factor()) / unit];
  };

  function axes(pen, wide, tall, matrix, eye) {
    const { low, high } = map, [ly, lx] = map.side;
    const flat = ([x, y, z]) => {
      const [u, v, , w] = [0, 1, 2, 3].map(
        (i) => matrix[i] * x + matrix[4 + i] * y + matrix[8 + i] * z + matrix[12 + i]);
      return [(u / w + 1) / 2 * wide, (1 - v / w) / 2 * tall];
    };
    const ink = getComputedStyle(area).color;
    Object.assign(pen, { strokeStyle: ink, fillStyle: ink, lineWidth: 1 });
    pen.font = `12px ${getComputedStyle(area).fontFamily}`;
    const line = (a, b, width = 1) => {
      pen.lineWidth = width;
      pen.beginPath();
      pen.moveTo(...flat(inScene(...a)));
      pen.lineTo(...flat(inScene(...b)));
      pen.stroke();
    };
    // The sides of the box that are behind the surface, seen from here.
    const x = eye[0] > 0 ? 0 : lx, y = eye[1] > 0 ? ly : 0, z = eye[2] > 0 ? low : high;
    const [ox, oy, oz] = [lx - x, ly - y, low + high - z];
    pen.globalAlpha = 0.35;
    for (const [a, b] of [
      [[x, y, z], [ox, y, z]], [[x, y, z], [x, oy, z]], [[x, y, z], [x, y, oz]],
      [[ox, y, z], [ox, oy, z]], [[x, oy, z], [ox, oy, z]], [[ox, y, z], [ox, y, oz]],
      [[x, oy, z], [x, oy, oz]], [[x, y, oz], [ox, y, oz]], [[x, y, oz], [x, oy, oz]],
    ]) line(a, b);
    pen.globalAlpha = 1;
    const [size, unit] = map.length, [tallness, heightUnit] = map.height;
    const ticks = (first, last, scale, name, symbol, at, away) => {
      const [a, b] = [flat(inScene(...at(first))), flat(inScene(...at(last)))];
      const parts = Math.max(Math.hypot(a[0] - b[0], a[1] - b[1]) / 60, 1.5);
      const step = round(((last - first) * scale) / parts) || 1;
      for (let n = Math.ceil((first * scale) / step - 1e-9); n * step <= last * scale * (1 + 1e-9); n++)
        text(number(n * step), at((n * step) / scale), away, 7);
      text(`${name} [${symbol}]`, at((first + last) / 2), away, 34);
    };
    const text = (words, place, away, gap) => {
      const point = flat(inScene(...place)), past = flat(inScene(...away(place)));
      let [u, v] = [point[0] - past[0], point[1] - past[1]];
      const long = Math.hypot(u, v) || 1;
      [u, v] = [u / long, v / long];
      if (gap < 10) {
        pen.beginPath();
        pen.moveTo(...point);
        pen.lineTo(point[0] + 4 * u, point[1] + 4 * v);
        pen.stroke();
      }
      pen.textAlign = u > 0.3 ? "left" : u < -0.3 ? "right" : "center";
      pen.textBaseline = v > 0.3 ? "top" : v < -0.3 ? "bottom" : "middle";
      pen.fillText(words, point[0] + gap * u, point[1] + gap * v);
    };
    ticks(0, lx, size, "x", unit, (t) => [t, oy, z], ([a, , c]) => [a, y, c]);
    ticks(0, ly, size, "y", unit, (t) => [ox, t, z], ([, b, c]) => [x, b, c]);
    const right = flat(inScene(ox, y, z))[0] > flat(inScene(x, oy, z))[0];
    const [ex, ey] = right ? [x, oy] : [ox, y];
    ticks(low, high, tallness, "height", heightUnit, (t) => [ex, ey, t],
          ([a, b, c]) => (right ? [ox, b, c] : [a, oy, c]));
    scaleBar(pen, tall, unit, size);
    colorBar(pen, wide, tall);
  }

  function scaleBar(pen, tall, unit, size) {
    const [ly, lx] = map.side;
    // Dots to a meter in the middle of the scene.
    const dots = tall / 2 / Math.tan(HALF_ANGLE) / look.distance / (Math.max(ly, lx) / 2);
    const long = round((110 / dots) * size);
    const width = (long / size) * dots;
    Object.assign(pen, { lineWidth: 3, textAlign: "left", textBaseline: "bottom" });
    pen.beginPath();
    pen.moveTo(12, tall - 12);
    pen.lineTo(12 + width, tall - 12);
    pen.stroke();
    pen.fillText(`${number(long)} ${unit} in the middle; heights \u00d7 ${number(factor())}`,
                 12, tall - 18);
  }

  function colorBar(pen, wide, tall) {
    const colors = model.palette, bottom = tall - 60, long = Math.min(tall - 120, 220);
    if (long < 40) return;
    for (let n = 0; n < long; n++) {
      pen.fillStyle = colors[1 + Math.floor((n / long) * 254)];
      pen.fillRect(wide - 74, bottom - n, 10, 1.5);
    }
    pen.fillStyle = getComputedStyle(area).color;
    Object.assign(pen, { textAlign: "left", textBaseline: "middle" });
    for (const [share, words] of shown.ticks)
      pen.fillText(words, wide - 60, bottom - share * long);
    pen.textAlign = "right";
    pen.fillText(shown.title, wide - 8, bottom - long - 16);
    if (shown.words) pen.fillText(shown.words, wide - 8, 14);
  }

  function draw() {
    waits = 0;
    if (map == null || shown == null || scene.clientWidth == 0) return;
    const [wide, tall] = [scene.clientWidth, scene.clientHeight], fine = devicePixelRatio;
    for (const canvas of [under, over])
      if (canvas.width != Math.round(wide * fine) || canvas.height != Math.round(tall * fine))
        Object.assign(canvas, { width: Math.round(wide * fine), height: Math.round(tall * fine) });
    const { matrix, eye } = camera(look, wide / tall);
    const pen = under.getContext("2d");
    pen.setTransform(fine, 0, 0, fine, 0, 0);
    pen.clearRect(0, 0, wide, tall);
    axes(pen, wide, tall, matrix, eye);
    const [ly, lx] = map.side, unit = Math.max(ly, lx) / 2;
    const middle = (map.low + map.high) / 2;
    drawn.draw(matrix, eye, [lx / map.nx / unit, ly / map.ny / unit], [middle, factor() / unit]);
    factorText.textContent = `\u00d7 ${number(factor())}`;
    const what = `Heights in 3-D, exaggerated ${number(factor())} times, colored by `
      + `${shown.title}${shown.words ? `, ${shown.words}` : ""}`;
    scene.setAttribute("aria-label", what);
    area.dataset.drawn = Number(area.dataset.drawn ?? 0) + 1;
  }
  const ask = () => { waits = waits || requestAnimationFrame(draw); };

  function takeHeights() {
    map = shown = null;
    for (const part of [scene, below]) part.hidden = model.heights.length == 0;
    if (model.heights.length == 0) return;
    map = JSON.parse(model.heights[0]);
    drawn.heights(new Float32Array(model.heights[1]), map.nx, map.ny);
    note.textContent = map.note;
  }
  function takeColors() {
    if (model.colors.length == 0) return;
    shown = JSON.parse(model.colors[0]);
    drawn.colors(new Uint8Array(model.colors[1]), shown.nx, shown.ny);
    const rgba = new Uint8Array(1024).fill(255);
    model.palette.forEach((color, n) => {
      for (let part = 0; part < 3; part++)
        rgba[4 * n + part] = parseInt(color.slice(1 + 2 * part, 3 + 2 * part), 16);
    });
    drawn.palette(rgba);
  }
  const limit = (value, low, high) => Math.min(high, Math.max(low, value));
  const turn = (right, up) => {
    look.yaw -= right;
    look.pitch = limit(look.pitch + up, -1.55, 1.55);
    ask();
  };
  const zoom = (by) => { look.distance = limit(look.distance * by, 1.6, 12); ask(); };
  const reset = () => { look = { ...START }; height.value = 0; ask(); };
  scene.addEventListener("pointerdown", (event) => scene.setPointerCapture(event.pointerId));
  scene.addEventListener("pointermove", (event) => {
    if (event.buttons) turn(event.movementX * 0.008, event.movementY * 0.008);
  });
  scene.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(event.deltaY * 0.001));
  }, { passive: false });
  scene.addEventListener("dblclick", reset);
  const keys = {
    ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0),
    ArrowUp: () => turn(0, -0.1), ArrowDown: () => turn(0, 0.1),
    "+": () => zoom(0.9), "-": () => zoom(1.1), 0: reset,
  };
  scene.addEventListener("keydown", (event) => {
    if (!(event.key in keys) || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    keys[event.key]();
  });
  height.addEventListener("input", ask);

  // A change of several of them comes as one message: the last of them draws.
  model.on("heights", () => { takeHeights(); takeColors(); ask(); });
  model.on("colors", () => { takeColors(); ask(); });
  model.on("palette", () => { takeColors(); ask(); });
  const watch = new ResizeObserver(ask);
  watch.observe(scene);
  const scheme = matchMedia("(prefers-color-scheme: dark)");
  scheme.addEventListener("change", ask);
  model.on("remove", () => {
    watch.disconnect();
    scheme.removeEventListener("change", ask);
    drawn.end();
  });
  takeHeights();
  takeColors();
  ask();
  return area;
}
