// Draws the eye's view with WebGL 2: sky, what lies flat (painter's order), what stands, lamps. The light is that of eye_light.js, for
// every pixel by its distance from the eye, encoded to sRGB and dithered by half a step, so that small contrasts are right in the mean.

/** Rain cells that a picture knows, at most: as many as a weather notice has. */
const MOST_CELLS = 100;

/** Extinction on the line from the eye: fog everywhere, the rain that falls halfway (eye_light.js, extinctionTo). */
const LINE = `
uniform vec3 uEye; uniform float uFog, uRain; uniform vec4 uCells[${MOST_CELLS}]; uniform int uCellCount; // east, north, radius, mm/h
float extinctionTo(vec3 at) {
  vec2 middle = 0.5 * (uEye.xy + at.xy);
  float rain = uRain;
  for (int i = 0; i < uCellCount; i++) if (distance(middle, uCells[i].xy) <= uCells[i].z) rain = max(rain, uCells[i].w);
  return uFog + 0.248e-3 * pow(max(rain, 1e-9), 0.67);
}`;

const AIR = `${LINE}
uniform float uExposure; uniform vec3 uHorizon;
vec3 air(vec3 l, vec3 at) { float t = exp(-extinctionTo(at) * distance(at, uEye)); return l * t + uHorizon * (1.0 - t); }
vec3 encoded(vec3 l) {
  vec3 x = clamp(l * uExposure, 0.0, 1.0);
  vec3 s = mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x));
  // A different draw for each pixel: interleaved gradient noise, flat from -1/2 to 1/2 of a step.
  float n = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  return s + n / 255.0;
}`;

const SOLID = [`#version 300 es
layout(location=0) in vec3 aAt; layout(location=1) in vec3 aNormal; layout(location=2) in vec3 aColour;
uniform mat4 uMatrix; uniform vec4 uPlace; // east, north, up, heading
out vec3 vAt, vNormal, vColour;
void main() {
  float s = sin(uPlace.w), c = cos(uPlace.w);
  vAt = vec3(aAt.x * c + aAt.y * s, aAt.y * c - aAt.x * s, aAt.z) + uPlace.xyz;
  vNormal = vec3(aNormal.x * c + aNormal.y * s, aNormal.y * c - aNormal.x * s, aNormal.z);
  vColour = aColour;
  gl_Position = uMatrix * vec4(vAt, 1.0);
}`, `#version 300 es
precision highp float;
in vec3 vAt, vNormal, vColour; out vec4 o;
uniform vec3 uSun; uniform float uSunLight, uSkyLight, uWet;
${AIR}
void main() {
  vec3 l = vColour; // a normal of 0: its own luminance
  float n = length(vNormal);
  if (n > 0.5) {
    vec3 normal = vNormal / n, to = normalize(vAt - uEye);
    if (dot(normal, to) > 0.0 && abs(normal.z) < 0.99) normal = -normal;
    l = vColour * (uSkyLight * (0.6 + 0.4 * normal.z) + uSunLight * max(0.0, dot(normal, uSun)));
    if (uWet > 0.0 && normal.z > 0.99 && vAt.z < 0.01) {
      float r = pow(1.0 - max(0.0, -to.z), 5.0) * 0.98 + 0.02; // Fresnel of water, by Schlick
      l = mix(l * (1.0 - 0.4 * uWet), uHorizon, r * uWet);
    }
  }
  o = vec4(encoded(air(l, vAt)), 1.0);
}`];

const SKY = [`#version 300 es
const vec2 P[3] = vec2[3](vec2(-1.0, -1.0), vec2(3.0, -1.0), vec2(-1.0, 3.0));
uniform vec3 uAhead, uRight, uUp; out vec3 vTo;
void main() { vec2 p = P[gl_VertexID]; vTo = uAhead + uRight * p.x + uUp * p.y; gl_Position = vec4(p, 1.0, 1.0); }`, `#version 300 es
precision highp float;
in vec3 vTo; out vec4 o; uniform vec3 uZenith;
${AIR}
void main() {
  float e = asin(normalize(vTo).z); // to 10 degrees the sky has the luminance of the horizon in every weather
  o = vec4(encoded(mix(uHorizon, uZenith, smoothstep(0.1745, 1.2, e))), 1.0);
}`];

const LAMP = [`#version 300 es
layout(location=0) in vec3 aAt; layout(location=1) in vec4 aLamp; layout(location=2) in vec2 aAim; // colour, candela; side
uniform mat4 uMatrix; uniform float uThreshold;
${LINE}
out vec4 vColour;
void main() {
  float d = max(5.0, distance(aAt, uEye)), e = aLamp.w * exp(-extinctionTo(aAt) * d) / (d * d), over = e / uThreshold;
  bool turned = dot(aAim, aAim) > 0.0 && dot(aAim, uEye.xy - aAt.xy) <= 0.0;
  gl_Position = turned || over < 1.0 ? vec4(2.0, 2.0, 2.0, 1.0) : uMatrix * vec4(aAt, 1.0);
  gl_PointSize = clamp(2.0 + 0.6 * log2(max(over, 1.0)), 2.0, 9.0);
  vColour = vec4(aLamp.rgb, clamp(0.25 + 0.12 * log2(max(over, 1.0)), 0.25, 1.0));
}`, `#version 300 es
precision highp float;
in vec4 vColour; out vec4 o;
void main() { float r = length(gl_PointCoord - 0.5) * 2.0; o = vec4(vColour.rgb, vColour.a * smoothstep(1.0, 0.45, r)); }`];

export class Renderer {
  /** Throws where there is no WebGL 2. */
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: false, alpha: false, preserveDrawingBuffer: true });
    if (!gl) throw new Error("this browser has no WebGL 2");
    this.gl = gl;
    this.canvas = canvas;
    this.programs = { solid: this.#program(SOLID), sky: this.#program(SKY), lamp: this.#program(LAMP) };
    this.empty = gl.createVertexArray();
    this.triangles = this.calls = 0;
  }

  #program([vertex, fragment]) {
    const { gl } = this, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    const found = new Map();
    return { program, at: (name) => found.get(name) ?? found.set(name, gl.getUniformLocation(program, name)).get(name) };
  }

  /** Vertices on the graphics side; `sizes` are the figures of each attribute. */
  upload(data, sizes = [3, 3, 3]) {
    const { gl } = this, vao = gl.createVertexArray(), buffer = gl.createBuffer(), width = sizes.reduce((a, b) => a + b);
    gl.bindVertexArray(vao);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    sizes.reduce((offset, size, i) => {
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, size, gl.FLOAT, false, width * 4, offset * 4);
      return offset + size;
    }, 0);
    gl.bindVertexArray(null);
    return { vao, buffer, count: data.length / width };
  }

  free(mesh) {
    if (!mesh) return;
    this.gl.deleteVertexArray(mesh.vao);
    this.gl.deleteBuffer(mesh.buffer);
  }

  /** One picture. light: { fog, rain, cells, exposure, horizon, zenith, sun, sunLight, skyLight, wet, threshold }; view: { matrix, eye, ahead, right, up }. */
  draw(light, view, { flats, solids, boards, models, lamps, worn }) {
    const { gl } = this;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.triangles = this.calls = 0;
    const common = ({ program, at }) => {
      gl.useProgram(program);
      gl.uniform3fv(at("uEye"), view.eye);
      gl.uniform1f(at("uFog"), light.fog);
      gl.uniform1f(at("uRain"), light.rain);
      const cells = light.cells.slice(0, MOST_CELLS);
      gl.uniform1i(at("uCellCount"), cells.length);
      if (cells.length) gl.uniform4fv(at("uCells"), cells.flat());
      gl.uniform1f(at("uExposure"), light.exposure);
      gl.uniform3fv(at("uHorizon"), light.horizon);
      gl.uniformMatrix4fv(at("uMatrix"), false, view.matrix);
      return at;
    };
    gl.disable(gl.BLEND);
    gl.disable(gl.DEPTH_TEST);
    let at = common(this.programs.sky);
    gl.uniform3fv(at("uZenith"), light.zenith);
    for (const [name, v] of [["uAhead", view.ahead], ["uRight", view.right], ["uUp", view.up]]) gl.uniform3fv(at(name), v);
    gl.bindVertexArray(this.empty);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    at = common(this.programs.solid);
    gl.uniform3fv(at("uSun"), light.sun);
    gl.uniform1f(at("uSunLight"), light.sunLight);
    gl.uniform1f(at("uSkyLight"), light.skyLight);
    const mesh = (m, place = [0, 0, 0, 0], wet = 0) => {
      if (!m?.count) return;
      gl.uniform4fv(at("uPlace"), place);
      gl.uniform1f(at("uWet"), wet);
      gl.bindVertexArray(m.vao);
      gl.drawArrays(gl.TRIANGLES, 0, m.count);
      this.triangles += m.count / 3;
      this.calls++;
    };
    mesh(flats, [0, 0, 0, 0], light.wet);
    gl.enable(gl.DEPTH_TEST);
    mesh(solids);
    mesh(boards);
    for (const { shape, place } of models) mesh(shape, place);
    at = common(this.programs.lamp);
    gl.uniform1f(at("uThreshold"), light.threshold);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    for (const points of [lamps, worn]) {
      if (!points?.count) continue;
      gl.bindVertexArray(points.vao);
      gl.drawArrays(gl.POINTS, 0, points.count);
      this.calls++;
    }
    gl.depthMask(true);
    gl.bindVertexArray(null);
  }
}
