"use strict";
// How surfaces look: plain (their colours alone), day (sky, sun, ambient occlusion), lit (a lamp in
// each room, which no wall lets through). One small shader, quick on machines without a GPU.

const LOOKS = { plain: 0, day: 1, lit: 2 };
const shared = { look: { value: LOOKS.day } };
const LAMP_BELOW_CEILING = 0.35; // metres
const LAMP = 1.9; // of a floor right below, as bright as a sheet of paper by day
const DARK = new THREE.Vector4(0, 0, 0, 0);

const LIGHT = `
uniform int look; uniform vec4 lamp; uniform float glow; varying vec3 place, out_;
vec3 lightOn(vec3 n) {
  if (look == 0) return vec3(1.0);
  if (look == 1) {
    if (n.y < -0.5) return vec3(0.88);
    return vec3(mix(0.62, 0.84, 0.5 + 0.5 * n.y) + 0.26 * max(dot(n, vec3(-0.45, 0.78, 0.43)), 0.0));
  }
  vec3 way = lamp.xyz - place;
  float far = dot(way, way);
  return vec3(1.0, 0.94, 0.86) * (0.42 + lamp.w * max(dot(n, way) * inversesqrt(far), 0.0) / (1.0 + 0.3 * far));
}`;

function patch(shader) {
  // Three's basic material with the light above; Neutral tone mapping takes the 4 % off again that a
  // dielectric's surface reflects.
  const swap = (text, from, to) => {
    if (!text.includes(from)) throw new Error(`three.js has no ${from}`);
    return text.replace(from, to);
  };
  shader.vertexShader = swap(`varying vec3 place, out_;\n${shader.vertexShader}`, "#include <begin_vertex>",
    `#include <begin_vertex>
    place = (modelMatrix * vec4(transformed, 1.0)).xyz; out_ = mat3(modelMatrix) * normal;`);
  let text = swap(shader.fragmentShader, "void main() {", `${LIGHT}\nvoid main() {`);
  text = swap(text, "reflectedLight.indirectDiffuse *= diffuseColor.rgb;",
    `reflectedLight.indirectDiffuse *= lightOn(normalize(gl_FrontFacing ? out_ : -out_))
      * (diffuseColor.rgb + (look == 0 ? 0.0 : 0.04));
    reflectedLight.indirectDiffuse = mix(reflectedLight.indirectDiffuse, vec3(0.95, 0.55, 0.25), glow);`);
  // Once a pixel, not once for each of the texels that it mixes: several times as quick without a GPU.
  text = swap(text, "#include <map_fragment>", `#ifdef USE_MAP
    diffuseColor *= sRGBTransferEOTF(texture2D(map, vMapUv));
    #endif`);
  shader.fragmentShader = swap(text, "#include <tonemapping_fragment>",
    `#if defined(TONE_MAPPING)
    if (look != 0) gl_FragColor.rgb = toneMapping(gl_FragColor.rgb);
    #endif`);
}

function paint(part, sharpness) {
  // A mesh's material, from what the file says about its colour.
  const { mesh } = part;
  const { map, aoMap, color, opacity, vertexColors, transparent } = mesh.material;
  const sides = part.glass || part.extras.kind === "ceiling" ? THREE.DoubleSide : THREE.FrontSide;
  const material = new THREE.MeshBasicMaterial({ map, aoMap, color, opacity, vertexColors, transparent, side: sides, depthWrite: !transparent });
  if (map) Object.assign(map, { anisotropy: sharpness, colorSpace: THREE.NoColorSpace }); // see patch
  part.uniforms = { glow: { value: 0 }, lamp: { value: DARK } };
  material.onBeforeCompile = (shader) => { Object.assign(shader.uniforms, shared, part.uniforms); patch(shader); };
  material.customProgramCacheKey = () => "house";
  mesh.material = material;
}

function hangLamps() {
  // Each room's lamp: the file's where it has one over this floor, else one in the middle.
  const middle = new Map(rooms.map((room) => {
    const own = lamps.find((lamp) => lamp.y > room.inside.y && lamp.y < room.inside.y + room.height && over(room, lamp));
    const place = own || room.inside.clone().setY(room.inside.y + room.height - LAMP_BELOW_CEILING);
    return [room.id, new THREE.Vector4(place.x, place.y, place.z, LAMP)];
  }));
  for (const part of parts) part.uniforms.lamp.value = middle.get(part.extras.room_id) || DARK;
}

function over(room, { x, z }) {
  if (!room.floor) return false;
  const point = new THREE.Vector3(x, room.inside.y, z);
  for (const triangle of trianglesOf(room.floor.mesh)) if (triangle.containsPoint(point)) return true;
  return false;
}

function setLook(name) {
  shared.look.value = LOOKS[name];
  for (const part of parts) part.mesh.material.aoMapIntensity = name === "plain" ? 0 : 1;
  for (const other of Object.keys(LOOKS)) $(other).setAttribute("aria-pressed", String(other === name));
  refresh();
}
