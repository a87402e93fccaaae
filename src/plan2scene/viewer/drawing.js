"use strict";
// WebGL 2: shaders, buffers, textures, and one picture of the parts.

const VERTEX = `#version 300 es
layout(location=0) in vec3 position; layout(location=1) in vec3 normal;
layout(location=2) in vec2 uv; layout(location=3) in vec3 colour;
layout(location=4) in vec2 shadeUv;
uniform mat4 camera; out vec3 n; out vec2 t; out vec3 c; out vec2 s;
void main() { n = normal; t = uv; c = colour; s = shadeUv; gl_Position = camera * vec4(position, 1.0); }`;
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 n; in vec2 t; in vec3 c; in vec2 s; out vec4 pixel;
uniform sampler2D tile, shade; uniform vec4 factor; uniform bool textured, shaded; uniform float glow;
vec3 encode(vec3 x) { return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x)); }
void main() {
  vec3 base = factor.rgb * c * (textured ? texture(tile, t).rgb : vec3(1.0));
  vec3 m = normalize(gl_FrontFacing ? n : -n);
  float light = mix(0.62, 0.84, 0.5 + 0.5 * m.y) + 0.26 * max(dot(m, vec3(-0.45, 0.78, 0.43)), 0.0);
  if (m.y < -0.5) light = 0.88;
  if (shaded) light *= texture(shade, s).r;
  vec3 lit = mix(base * light, vec3(0.95, 0.55, 0.25), glow);
  pixel = vec4(encode(clamp(lit, 0.0, 1.0)), factor.a);
}`;
function shader(type, source) {
  const made = gl.createShader(type);
  gl.shaderSource(made, source);
  gl.compileShader(made);
  if (!gl.getShaderParameter(made, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(made));
  return made;
}

function startGl() {
  // Edges are smoothed by drawing larger (draw): multisampling lets the wall behind a corner
  // shine through on software renderers.
  gl = canvas.getContext("webgl2", { antialias: false });
  if (!gl) throw new Error("This browser has no WebGL 2. house.glb opens in any glTF program.");
  program = gl.createProgram();
  gl.attachShader(program, shader(gl.VERTEX_SHADER, VERTEX));
  gl.attachShader(program, shader(gl.FRAGMENT_SHADER, FRAGMENT));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  uniforms = Object.fromEntries(["camera", "tile", "factor", "textured", "glow", "shade", "shaded"].map((n) => [n, gl.getUniformLocation(program, n)]));
  gl.enable(gl.DEPTH_TEST);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
}

function uploadPart(part) {
  part.array = gl.createVertexArray();
  gl.bindVertexArray(part.array);
  const fallback = { 1: [0, 1, 0], 2: [0, 0], 3: [1, 1, 1], 4: [0, 0] };
  [[part.position, 3], [part.normal, 3], [part.uv, 2], [part.colour, 3], [part.shadeUv, 2]].forEach(([data, size], place) => {
    if (!data) { gl[`vertexAttrib${size}fv`](place, fallback[place]); return; }
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
  });
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, part.index, gl.STATIC_DRAW);
  part.type = part.index instanceof Uint16Array ? gl.UNSIGNED_SHORT : gl.UNSIGNED_INT;
}

// The occlusion is no colour, does not repeat, and its parts would run together in smaller copies.
function uploadShade(image) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, gl.RED, gl.UNSIGNED_BYTE, image);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  URL.revokeObjectURL(image.src);
  return made;
}

function uploadTexture(image) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
  gl.generateMipmap(gl.TEXTURE_2D);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  const sharp = gl.getExtension("EXT_texture_filter_anisotropic");
  if (sharp) gl.texParameterf(gl.TEXTURE_2D, sharp.TEXTURE_MAX_ANISOTROPY_EXT, Math.min(8, gl.getParameter(sharp.MAX_TEXTURE_MAX_ANISOTROPY_EXT)));
  URL.revokeObjectURL(image.src);
  return made;
}

// Ceilings that are shown also close the house from above.
const twoSided = (part) => part.glass || part.extras.kind === "ceiling";
const shown = (part) => (part.extras.kind !== "ceiling" || show.ceilings) && (part.extras.kind !== "structure" || show.shells);

function draw() {
  const scale = Math.max(2, window.devicePixelRatio || 1);
  const width = Math.round(canvas.clientWidth * scale), height = Math.round(canvas.clientHeight * scale);
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  gl.viewport(0, 0, width, height);
  gl.clearColor(0.969, 0.965, 0.953, 1);
  gl.depthMask(true);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.useProgram(program);
  gl.uniformMatrix4fv(uniforms.camera, false, matrix());
  gl.uniform1i(uniforms.tile, 0);
  gl.uniform1i(uniforms.shade, 1);
  const glow = 0.3 * Math.max(0, 1 - (performance.now() - chosenAt) / FLASH);
  for (const glass of [false, true]) {
    gl[glass ? "enable" : "disable"](gl.BLEND);
    gl.depthMask(!glass);
    for (const part of parts) {
      if (part.glass !== glass || !shown(part)) continue;
      gl[twoSided(part) ? "disable" : "enable"](gl.CULL_FACE);
      gl.bindVertexArray(part.array);
      gl.vertexAttrib3f(3, 1, 1, 1);
      gl.uniform4fv(uniforms.factor, part.factor);
      gl.uniform1i(uniforms.textured, part.image === null ? 0 : 1);
      gl.uniform1f(uniforms.glow, part === chosen ? glow : 0);
      gl.uniform1i(uniforms.shaded, part.shade === null ? 0 : 1);
      for (const [unit, image] of [[gl.TEXTURE1, part.shade], [gl.TEXTURE0, part.image]]) {
        gl.activeTexture(unit);
        if (image !== null) gl.bindTexture(gl.TEXTURE_2D, textures[image]);
      }
      gl.drawElements(gl.TRIANGLES, part.index.length, part.type, 0);
    }
  }
}
