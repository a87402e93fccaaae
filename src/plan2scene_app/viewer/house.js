"use strict";
// The page's data: the meshes of the house from its GLB, rooms, storeys, photos.

const $ = (id) => document.getElementById(id);
const facts = JSON.parse($("facts").textContent); // {surfaces: {"room/surface": ...}, photos: [...]}
const parts = []; // one for each mesh: {mesh, name, extras, glass, unlit, box}
const lamps = []; // positions of the lamps in the file
let rooms = [], levels = []; // levels: [{id, name, elevation}], lowest first

async function houseBytes() {
  // Unpacks the GLB, which is stored as gzip in base64.
  const raw = atob($("house").textContent.trim());
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

function embeddedImages(parser) {
  // Decodes the file's images without a request, because the page's content policy forbids requests.
  // Normal maps are removed: the page's shader does not use them.
  const made = new Map();
  for (const material of parser.json.materials || []) delete material.normalTexture;
  parser.loadImageSource = (index) => {
    if (!made.has(index)) {
      made.set(index, (async () => {
        const { bufferView, mimeType } = parser.json.images[index];
        const data = await parser.getDependency("bufferView", bufferView);
        const options = { colorSpaceConversion: "none", premultiplyAlpha: "none" };
        const texture = new THREE.Texture(await createImageBitmap(new Blob([data], { type: mimeType }), options));
        texture.needsUpdate = true;
        texture.userData.mimeType = mimeType;
        return texture;
      })());
    }
    // A copy, because another texture of the same image may have another sampler.
    return made.get(index).then((texture) => texture.clone());
  };
  return { name: "embedded images" };
}

async function readHouse() {
  const loader = new THREE.GLTFLoader();
  loader.register(embeddedImages);
  const gltf = await loader.parseAsync(await houseBytes(), "");
  gltf.scene.updateMatrixWorld(true);
  const lights = [];
  gltf.scene.traverse((node) => {
    if (node.isMesh) {
      const { name, ...extras } = node.userData;
      const { material } = node;
      node.part = { mesh: node, name: name || node.name, extras, glass: material.transparent, unlit: material.isMeshBasicMaterial, box: new THREE.Box3().setFromObject(node) };
      parts.push(node.part);
    } else if (node.isPointLight || node.isSpotLight) {
      lamps.push(node.getWorldPosition(new THREE.Vector3()));
    }
    if (node.isLight) lights.push(node);
  });
  for (const light of lights) light.removeFromParent(); // the page has its own lighting
  listOf(gltf.scene.userData);
  return gltf.scene;
}

function listOf({ rooms: entries = [], levels: storeys = [] }) {
  // Lists the rooms with unique titles, the area of their floor, and a point inside.
  const kind = (room) => room.name ?? room.types.join(" / ");
  const count = new Map(), seen = new Map();
  entries.forEach((room) => count.set(kind(room), (count.get(kind(room)) || 0) + 1));
  levels = [...storeys].sort((a, b) => a.elevation - b.elevation);
  rooms = entries.map((room) => {
    seen.set(kind(room), (seen.get(kind(room)) || 0) + 1);
    const floor = parts.find((part) => part.name === `${room.id}/floor`);
    const title = count.get(kind(room)) > 1 ? `${kind(room)} ${seen.get(kind(room))}` : kind(room);
    const size = floor ? areaOf(floor) : 0;
    return { ...room, title, size, floor, inside: floor ? insideOf(floor) : new THREE.Vector3() };
  });
  const home = new Map(rooms.map((room) => [room.id, room]));
  for (const part of parts) part.level = part.extras.level ?? home.get(part.extras.room_id)?.level ?? null;
}

function* trianglesOf(mesh) {
  // Yields the world triangles of a mesh; it reuses one object for all of them.
  const { index, attributes } = mesh.geometry;
  const triangle = new THREE.Triangle();
  const count = index ? index.count : attributes.position.count;
  for (let k = 0; k < count; k += 3) {
    [triangle.a, triangle.b, triangle.c].forEach((corner, j) => {
      corner.fromBufferAttribute(attributes.position, index ? index.getX(k + j) : k + j).applyMatrix4(mesh.matrixWorld);
    });
    yield triangle;
  }
}

function areaOf(part) {
  let sum = 0;
  for (const triangle of trianglesOf(part.mesh)) sum += triangle.getArea();
  return sum;
}

function insideOf(floor) {
  // Centre of the floor's largest triangle, which is inside a room of any shape.
  const point = new THREE.Vector3();
  let best = -1;
  for (const triangle of trianglesOf(floor.mesh)) {
    if (triangle.getArea() > best) { best = triangle.getArea(); triangle.getMidpoint(point); }
  }
  return point;
}

function boxOf(list) {
  const box = new THREE.Box3();
  for (const part of list) box.union(part.box);
  return box;
}
