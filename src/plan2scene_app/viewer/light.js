"use strict";
// Looks of surfaces: plain (only their colours), day (sky, sun, ambient occlusion), lit (a lamp in each
// room, which lights only this room). One small shader that is fast without a GPU: it uses the square of
// an sRGB value as linear light, so that a surface in full light shows exactly its colour.

const LOOKS = { plain: 0, day: 1, lit: 2 };
const LAMP_BELOW_CEILING = 0.35; // metres
const LAMP = 1.1; // strength of a lamp: light on a floor right below it, about that of paper by day
const SWITCHED = new Set(["ceiling", "structure"]); // kinds that the panel can hide
const gathered = []; // meshes that replace several parts: {mesh, members, box}
const DARK = new THREE.Vector4(0, 0, 0, 0);

// The Khronos neutral tone mapping without branches, which are slow without a GPU.
const NEUTRAL = `
vec3 neutral(vec3 colour) {
  float low = min(min(colour.r, min(colour.g, colour.b)), 0.08);
  colour -= low - 6.25 * low * low;
  float peak = max(0.76, max(colour.r, max(colour.g, colour.b))), end = 1.0 - 0.0576 / (peak - 0.52);
  return mix(vec3(end), colour * (end / peak), 1.0 / (0.15 * (peak - end) + 1.0));
}`;

// The light of the sky is computed at vertices, that of a lamp at each pixel. Floors get hardly more light
// than walls, because a floor's colour was estimated from its ratio to the walls in photos.
const SKY = `
#if LOOK == 1
varying float sky;
float skyLight(vec3 n) {
  return n.y < -0.5 ? 0.92 : n.y > 0.5 ? 0.97 : mix(0.78, 0.86, 0.5 + 0.5 * n.y) + 0.26 * max(dot(n, vec3(-0.45, 0.78, 0.43)), 0.0);
}
#elif LOOK == 2
varying vec3 place, out_;
#endif
`;
// The fragment shader, as short as possible. It adds the 4 % that a dielectric's surface reflects; tone
// mapping takes them off again.
const PIXEL = `
uniform vec3 diffuse; uniform float opacity, glow; uniform vec4 lamp;
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <aomap_pars_fragment>
#if LOOK == 1
varying float sky;
#elif LOOK == 2
varying vec3 place, out_;
#endif
${NEUTRAL}
void main() {
  vec4 colour = vec4(diffuse, opacity);
  #if defined(USE_COLOR) || defined(USE_COLOR_ALPHA)
  colour.rgb *= vColor.rgb;
  #endif
  #ifdef USE_MAP
  vec4 texel = texture2D(map, vMapUv);
  colour *= vec4(texel.rgb * texel.rgb, texel.a);
  #endif
  #if LOOK == 1
  colour.rgb = sky * (colour.rgb + 0.04);
  #elif LOOK == 2
  vec3 way = lamp.xyz - place, n = gl_FrontFacing ? out_ : -out_;
  float far = dot(way, way), share = max(dot(n, way) * inversesqrt(far), 0.0) / (1.0 + 0.3 * far);
  colour.rgb = vec3(1.0, 0.94, 0.86) * (0.72 + lamp.w * share) * (colour.rgb + 0.04);
  #endif
  colour.rgb = mix(colour.rgb, vec3(0.95, 0.55, 0.25), glow);
  #if LOOK != 0
  #ifdef USE_AOMAP
  colour.rgb *= texture2D(aoMap, vAoMapUv).r;
  #endif
  colour.rgb = neutral(colour.rgb);
  #endif
  #ifdef OPAQUE
  colour.a = 1.0;
  #endif
  gl_FragColor = vec4(sqrt(colour.rgb), colour.a);
}`;

function patch(shader) {
  const from = "#include <begin_vertex>";
  if (!shader.vertexShader.includes(from)) throw new Error(`three.js has no ${from}`);
  shader.vertexShader = SKY + shader.vertexShader.replace(from, `${from}
    #if LOOK == 1
    sky = skyLight(mat3(modelMatrix) * normal);
    #elif LOOK == 2
    place = (modelMatrix * vec4(transformed, 1.0)).xyz; out_ = mat3(modelMatrix) * normal;
    #endif`);
  shader.fragmentShader = PIXEL;
}

function squared(linear) {
  // The square of the sRGB value that belongs to a linear value.
  return (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055) ** 2;
}

function paint(part, sharpness) {
  // Replaces a mesh's material by one of this page, with the colour that the file gives.
  const { mesh } = part;
  const { map, aoMap, color, opacity, vertexColors, transparent } = mesh.material;
  const sides = part.glass || part.extras.kind === "ceiling" ? THREE.DoubleSide : THREE.FrontSide;
  const tint = color.clone().setRGB(...color.toArray().map(squared)); // a copy: other meshes share the material
  if (vertexColors) mesh.geometry.setAttribute("color", new THREE.Float32BufferAttribute(Array.from(mesh.geometry.attributes.color.array, squared), mesh.geometry.attributes.color.itemSize));
  const material = new THREE.MeshBasicMaterial({ map, aoMap, color: tint, opacity, vertexColors, transparent, side: sides, depthWrite: !transparent });
  if (map) {
    Object.assign(map, { anisotropy: sharpness, colorSpace: THREE.NoColorSpace }); // the shader decodes it, see patch
    if (sharpness === 1) map.minFilter = THREE.LinearMipmapNearestFilter;
  }
  part.look = mesh.material.uuid;
  part.uniforms = { glow: { value: 0 }, lamp: { value: DARK } };
  mesh.material = shine(material, part.uniforms);
}

function shine(material, uniforms) {
  material.onBeforeCompile = (shader) => { Object.assign(shader.uniforms, uniforms); patch(shader); };
  material.customProgramCacheKey = () => "house";
  return material;
}

function gather(scene) {
  // Joins parts of a room that look alike into one mesh for the view from outside, because each draw call
  // is slow without a GPU. The parts stay for clicks; a chosen or painted part is drawn over the mesh.
  const groups = new Map();
  for (const part of parts) {
    const { geometry, matrixWorld } = part.mesh, { kind, room_id } = part.extras;
    const key = [part.look, part.level, room_id, SWITCHED.has(kind) && kind, Object.keys(geometry.attributes), matrixWorld.elements].join(" ");
    if (!part.glass) groups.set(key, [...(groups.get(key) ?? []), part]);
  }
  for (const members of groups.values()) {
    if (members.length < 2) continue;
    const [{ mesh: first, uniforms }] = members, geometry = new THREE.BufferGeometry(), index = [];
    for (const [name, { itemSize }] of Object.entries(first.geometry.attributes)) {
      const values = [];
      for (const { mesh: { geometry: { attributes: { [name]: own } } } } of members)
        for (let k = 0; k < own.count; k++) for (let j = 0; j < itemSize; j++) values.push(own.getComponent(k, j));
      geometry.setAttribute(name, new THREE.Float32BufferAttribute(values, itemSize));
    }
    let start = 0;
    for (const { mesh: { geometry: { index: own, attributes: { position: { count } } } } } of members) {
      for (let k = 0; k < (own ? own.count : count); k++) index.push(start + (own ? own.getX(k) : k));
      start += count;
    }
    geometry.setIndex(index);
    const mesh = new THREE.Mesh(geometry, shine(first.material.clone(), { glow: { value: 0 }, lamp: uniforms.lamp }));
    first.matrixWorld.decompose(mesh.position, mesh.quaternion, mesh.scale);
    mesh.part = { mesh, members, box: boxOf(members) };
    gathered.push(mesh.part);
    scene.add(mesh);
    for (const part of members) { part.gathered = true; part.mesh.renderOrder = 1; }
  }
}

function hangLamps() {
  // Sets each room's lamp: the file's lamp over this floor if there is one, else one at its inside point.
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
  for (const { mesh: { material } } of [...parts, ...gathered]) {
    Object.assign(material, { defines: { LOOK: LOOKS[name] }, needsUpdate: true });
  }
  for (const other of Object.keys(LOOKS)) $(other).setAttribute("aria-pressed", String(other === name));
  refresh();
}
