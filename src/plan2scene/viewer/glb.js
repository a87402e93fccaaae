"use strict";
// Reads the part of glTF 2.0 that this program writes: one primitive per mesh, nodes without
// transforms, PNG images in the binary chunk.

function base64Bytes(text) {
  const raw = atob(text.trim());
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return bytes;
}

function readGlb(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (view.getUint32(0, true) !== 0x46546c67) throw new Error("no GLB in this page");
  const size = view.getUint32(12, true);
  const json = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + size)));
  return { json, binary: bytes.subarray(20 + size + 8) };
}

const COMPONENTS = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

function accessor({ json, binary }, index) {
  const { bufferView, componentType, count, type } = json.accessors[index];
  const start = binary.byteOffset + json.bufferViews[bufferView].byteOffset;
  const array = { 5126: Float32Array, 5125: Uint32Array, 5123: Uint16Array }[componentType];
  // A copy: the chunk need not be aligned in the page's memory.
  const length = count * COMPONENTS[type] * array.BYTES_PER_ELEMENT;
  return new array(binary.buffer.slice(start, start + length));
}

function readParts(glb) {
  const { json } = glb;
  return json.nodes.filter((node) => node.mesh !== undefined).map((node) => {
    const primitive = json.meshes[node.mesh].primitives[0];
    const at = primitive.attributes;
    const get = (name) => (at[name] === undefined ? null : accessor(glb, at[name]));
    const material = json.materials[primitive.material];
    const pbr = material.pbrMetallicRoughness;
    return {
      name: node.name,
      extras: node.extras || {},
      position: get("POSITION"),
      normal: get("NORMAL"),
      uv: get("TEXCOORD_0"),
      shadeUv: get("TEXCOORD_1"),
      colour: get("COLOR_0"),
      index: accessor(glb, primitive.indices),
      factor: pbr.baseColorFactor || [1, 1, 1, 1],
      image: pbr.baseColorTexture ? json.textures[pbr.baseColorTexture.index].source : null,
      shade: material.occlusionTexture ? json.textures[material.occlusionTexture.index].source : null,
      glass: material.alphaMode === "BLEND",
    };
  });
}

function readImages({ json, binary }) {
  return Promise.all((json.images || []).map((image) => new Promise((resolve, reject) => {
    const { byteOffset, byteLength } = json.bufferViews[image.bufferView];
    const data = binary.slice(byteOffset, byteOffset + byteLength);
    const element = new Image();
    element.onload = () => resolve(element);
    element.onerror = () => reject(new Error(`texture ${image.name} does not decode`));
    element.src = URL.createObjectURL(new Blob([data], { type: image.mimeType }));
  })));
}
